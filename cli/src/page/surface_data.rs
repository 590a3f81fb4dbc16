//! Mesh and distances as small integers for the page's `surface.js`.
//!
//! Vertices are numbered by first use, so that differences are small. Positions are rounded to 65,535 steps along the
//! longest side of the bounding box.

use neural_mesh::mesh::{IrregularEdges, TriMesh};
use serde::Serialize;

use super::packed::Packed;

const STEPS: f64 = 65_535.0;

/// Header of the packed numbers.
#[derive(Clone, Debug, Serialize)]
pub struct SurfaceLayout {
    vertices: usize,
    faces: usize,
    /// Numbers of marked edges: open, non-manifold, turned (between faces of opposite orientation).
    marked: [usize; 3],
    low: [f64; 3],
    sides: [f64; 3],
    step: f64,
    /// Distance samples along each side of a face; 1 if distances are at the vertices.
    pub steps: usize,
}

/// Mesh as the numbers that the page reads.
pub struct SurfaceData {
    /// Counts, bounding box and steps.
    pub layout: SurfaceLayout,
    /// Packed numbers: positions axis by axis, faces, marked edges.
    pub text: String,
    order: Vec<u32>,
}

impl SurfaceData {
    /// Quantises and packs a mesh with `steps` distance samples along each side of a face.
    pub fn new(mesh: &TriMesh, marked: &IrregularEdges, steps: usize) -> Self {
        let (order, number) = order_by_first_use(mesh);
        let (low, sides) = bounding_box(mesh.positions());
        let step = sides.into_iter().fold(0.0, f64::max) / STEPS;
        let mut packed = Packed::default();
        pack_positions(&mut packed, mesh.positions(), &order, low, step);
        pack_faces(&mut packed, mesh.faces(), &number);
        let kinds = [&marked.open, &marked.non_manifold, &marked.turned];
        kinds.iter().for_each(|edges| pack_edges(&mut packed, edges, &number));
        let (vertices, faces) = (order.len(), mesh.faces().len());
        let layout = SurfaceLayout { vertices, faces, marked: kinds.map(Vec::len), low, sides, step, steps };
        Self { layout, text: packed.text(), order }
    }

    /// Returns the number of each mesh vertex on the page, `u32::MAX` for unused vertices.
    pub fn numbers(&self, n_vertices: usize) -> Vec<u32> {
        let mut numbers = vec![u32::MAX; n_vertices];
        for (number, &vertex) in self.order.iter().enumerate() {
            numbers[vertex as usize] = number as u32;
        }
        numbers
    }

    /// Packs one value from 0 to `max` per vertex or sample point.
    pub fn pack_values(&self, packed: &mut Packed, values: &[f32], max: f32) {
        match self.layout.steps {
            1 => pack_roots(packed, self.order.iter().map(|&vertex| values[vertex as usize]), max),
            _ => pack_roots(packed, values.iter().copied(), max),
        }
    }
}

/// Packs square roots of values up to `max`; roots keep more digits of small values.
fn pack_roots(packed: &mut Packed, values: impl Iterator<Item = f32>, max: f32) {
    let mut before = 0;
    for value in values {
        let root = if max > 0.0 { (STEPS * f64::from(value / max).sqrt()).round() as u32 } else { 0 };
        packed.push_difference(root, before);
        before = root;
    }
}

/// Returns the vertices in order of first use, and the position of each in that order (`u32::MAX` if unused).
fn order_by_first_use(mesh: &TriMesh) -> (Vec<u32>, Vec<u32>) {
    let mut number = vec![u32::MAX; mesh.positions().len()];
    let mut order = Vec::with_capacity(number.len());
    for &vertex in mesh.faces().iter().flatten() {
        if number[vertex as usize] == u32::MAX {
            number[vertex as usize] = order.len() as u32;
            order.push(vertex);
        }
    }
    (order, number)
}

fn bounding_box(positions: &[[f32; 3]]) -> ([f64; 3], [f64; 3]) {
    let corner = |pick: fn(f32, f32) -> f32| {
        let all = positions.iter().copied();
        all.reduce(|a, b| std::array::from_fn(|axis| pick(a[axis], b[axis]))).unwrap_or_default().map(f64::from)
    };
    let (low, high) = (corner(f32::min), corner(f32::max));
    (low, std::array::from_fn(|axis| high[axis] - low[axis]))
}

fn pack_positions(packed: &mut Packed, positions: &[[f32; 3]], order: &[u32], low: [f64; 3], step: f64) {
    for axis in 0..3 {
        let mut before = 0;
        for &vertex in order {
            let offset = f64::from(positions[vertex as usize][axis]) - low[axis];
            let steps = if step > 0.0 { (offset / step).round() as u32 } else { 0 };
            packed.push_difference(steps, before);
            before = steps;
        }
    }
}

/// Packs each corner as the distance of its vertex number below the next unused one; 0 is a new vertex.
fn pack_faces(packed: &mut Packed, faces: &[[u32; 3]], number: &[u32]) {
    let mut next = 0;
    for &vertex in faces.iter().flatten() {
        let number = number[vertex as usize];
        packed.push(next - number);
        next = next.max(number + 1);
    }
}

fn pack_edges(packed: &mut Packed, edges: &[[u32; 2]], number: &[u32]) {
    let mut before = 0;
    for &vertex in edges.iter().flatten() {
        packed.push_difference(number[vertex as usize], before);
        before = number[vertex as usize];
    }
}

#[cfg(test)]
mod tests {
    use super::super::check::unpack_numbers;
    use super::super::packed::tests::decode_difference;
    use super::*;
    use neural_mesh::mesh::{irregular_edges, shapes};

    fn sum_differences(differences: &[u32]) -> Vec<u32> {
        let mut before = 0;
        let mut next = |&difference: &u32| {
            before = decode_difference(difference, before);
            before
        };
        differences.iter().map(&mut next).collect()
    }

    fn read_back(data: &SurfaceData) -> (Vec<[f64; 3]>, Vec<u32>, Vec<Vec<u32>>) {
        let SurfaceLayout { vertices, faces, marked, low, step, .. } = &data.layout;
        let numbers = unpack_numbers(&data.text);
        let (axes, rest) = numbers.split_at(3 * vertices);
        let axes: Vec<Vec<u32>> = axes.chunks(*vertices).map(sum_differences).collect();
        let position = |i: usize| std::array::from_fn(|axis| low[axis] + step * f64::from(axes[axis][i]));
        let (corners, mut rest) = rest.split_at(3 * faces);
        let mut next = 0;
        let corner = |below: &u32| {
            let number = next - below;
            next = next.max(number + 1);
            number
        };
        let corners = corners.iter().map(corner).collect();
        let edges = marked.map(|n| {
            let (edges, after) = rest.split_at(2 * n);
            rest = after;
            sum_differences(edges)
        });
        assert!(rest.is_empty());
        ((0..*vertices).map(position).collect(), corners, edges.into())
    }

    fn check(mesh: &TriMesh) {
        let marked = irregular_edges(mesh);
        let data = SurfaceData::new(mesh, &marked, 1);
        let (positions, corners, edges) = read_back(&data);
        let wanted: Vec<u32> = mesh.faces().iter().flatten().copied().collect();
        assert_eq!(corners.iter().map(|&v| data.order[v as usize]).collect::<Vec<_>>(), wanted);
        for (found, &vertex) in positions.iter().zip(&data.order) {
            for axis in 0..3 {
                let wanted = f64::from(mesh.positions()[vertex as usize][axis]);
                assert!((found[axis] - wanted).abs() <= 0.5001 * data.layout.step, "{found:?}");
            }
        }
        for (found, wanted) in edges.iter().zip([&marked.open, &marked.non_manifold, &marked.turned]) {
            let found: Vec<u32> = found.iter().map(|&v| data.order[v as usize]).collect();
            assert_eq!(found, wanted.as_flattened());
        }
    }

    #[test]
    fn unpacked_meshes_match_to_half_a_step() {
        check(&shapes::icosphere(3));
        check(&shapes::bolt(16));
        check(&shapes::grid(7, 5));
        check(&TriMesh::new(vec![[3.0; 3], [4.0, -1.0, 1e-3], [1e3; 3], [7.0; 3]], vec![[3, 0, 2]]).unwrap());
        check(&TriMesh::new(vec![[2.0; 3]; 3], vec![[2, 1, 0]]).unwrap());
    }

    #[test]
    fn small_values_keep_more_digits() {
        let mesh = shapes::icosphere(3);
        let data = SurfaceData::new(&mesh, &irregular_edges(&mesh), 1);
        let values: Vec<f32> = (0..mesh.positions().len()).map(|i| (i as f32 / 100.0).powi(3)).collect();
        let max = *values.last().unwrap();
        let mut packed = Packed::default();
        data.pack_values(&mut packed, &values, max);
        let roots = sum_differences(&unpack_numbers(&packed.text()));
        for (root, &vertex) in roots.iter().zip(&data.order) {
            let (found, wanted) = (max * (*root as f32 / 65535.0).powi(2), values[vertex as usize]);
            let bound = max * ((wanted / max).sqrt() / 65535.0 + 1e-9) + 1e-6 * wanted;
            assert!((found - wanted).abs() <= bound, "{found} is not {wanted}");
        }
    }

    #[test]
    fn without_any_distance_all_values_are_zero() {
        let mesh = shapes::icosphere(0);
        let mut packed = Packed::default();
        SurfaceData::new(&mesh, &irregular_edges(&mesh), 1).pack_values(&mut packed, &[0.0; 12], 0.0);
        assert_eq!(unpack_numbers(&packed.text()), [0; 12]);
    }
}
