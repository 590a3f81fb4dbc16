//! The cotangent Laplacian of any mesh with lumped masses (Sharp and Crane 2020, "A Laplacian for Nonmanifold Triangle
//! Meshes").

mod delaunay;
mod glued_triangles;
mod tufted;

use rayon::prelude::*;

use neural_mesh::geometry::side_lengths::{area, opposite_cotangent};
use neural_mesh::mesh::TriMesh;
use neural_mesh::mesh::union_find::UnionFind;

pub use glued_triangles::GluedTriangles;

const MOLLIFICATION: f64 = 1e-5;

/// The Laplacian `(L u)_i = sum_j w_ij (u_i - u_j)` and the masses `M` of the used vertices.
///
/// Boundaries are natural (Neumann). Eigenvalues of `L u = lambda M u` are in inverse squares of the mesh's unit.
#[derive(Clone, Debug)]
pub struct Laplacian {
    /// Used vertices of the mesh, ascending, n.
    pub vertices: Vec<u32>,
    /// Pairs `i < j` of indices into `vertices`, ascending, with weight `w_ij`.
    pub edges: Vec<([u32; 2], f64)>,
    /// Area around each vertex, n; positive.
    pub mass: Vec<f64>,
    /// Component of each vertex, named by its first vertex, n.
    pub component: Vec<u32>,
    // The tufted cover after the flips: two copies of each face, with indices into `vertices`.
    pub(super) surface: GluedTriangles,
}

impl Laplacian {
    /// Builds the Laplacian; `None` where no face has area.
    pub fn new(mesh: &TriMesh) -> Option<Self> {
        // The cover closes the surface, mollification gives triangles area, and flips make the weights positive.
        let mut surface = tufted::tufted_cover(mesh);
        surface.mollify(MOLLIFICATION);
        if surface.mean_length() <= 0.0 || !surface.mean_length().is_finite() {
            return None;
        }
        delaunay::flip_to_delaunay(&mut surface);
        let vertices = renumber_used(&mut surface.start, mesh.positions().len());
        let edges = edges(&surface);
        let component = components(vertices.len(), &edges);
        Some(Self { edges, mass: vertex_masses(&surface, vertices.len()), component, vertices, surface })
    }
}

fn renumber_used(start: &mut [u32], n_vertices: usize) -> Vec<u32> {
    let mut place = vec![u32::MAX; n_vertices];
    start.iter().for_each(|&v| place[v as usize] = 0);
    let used: Vec<u32> = (0..n_vertices as u32).filter(|&v| place[v as usize] == 0).collect();
    used.iter().enumerate().for_each(|(at, &v)| place[v as usize] = at as u32);
    start.iter_mut().for_each(|v| *v = place[*v as usize]);
    used
}

fn edges(surface: &GluedTriangles) -> Vec<([u32; 2], f64)> {
    let weight = |half_edge: usize| {
        let [a, b] = surface.ends(half_edge);
        ([a.min(b), a.max(b)], 0.25 * opposite_cotangent(surface.sides(half_edge)))
    };
    let mut parts: Vec<_> = (0..surface.twin.len()).map(weight).filter(|([a, b], _)| a != b).collect();
    // A stable sort fixes the order in which weights are summed.
    parts.par_sort_by_key(|(ends, _)| *ends);
    let sum = |parts: &[([u32; 2], f64)]| (parts[0].0, parts.iter().map(|(_, weight)| weight).sum());
    parts.chunk_by(|a, b| a.0 == b.0).map(sum).collect()
}

fn vertex_masses(surface: &GluedTriangles, n_vertices: usize) -> Vec<f64> {
    let mut mass = vec![0.0; n_vertices];
    for face in 0..surface.twin.len() / 3 {
        // A corner has a third of the face, halved because each face has two copies.
        let share = area(surface.sides(3 * face)) / 6.0;
        surface.start[3 * face..3 * face + 3].iter().for_each(|&v| mass[v as usize] += share);
    }
    mass
}

fn components(n_vertices: usize, edges: &[([u32; 2], f64)]) -> Vec<u32> {
    let mut sets = UnionFind::new(n_vertices);
    edges.iter().for_each(|([a, b], _)| _ = sets.union(*a, *b));
    (0..n_vertices as u32).map(|v| sets.find(v)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use neural_mesh::mesh::shapes;
    use std::collections::BTreeMap;

    fn naive(mesh: &TriMesh) -> BTreeMap<[u32; 2], f64> {
        let mut weights = BTreeMap::new();
        for face in mesh.faces() {
            for k in 0..3 {
                let [a, b, c] = [0, 1, 2].map(|i| face[(k + i) % 3]);
                let [p, q, r] = [a, b, c].map(|v| DVec3::from_array(mesh.positions()[v as usize].map(f64::from)));
                let cotangent = (p - r).dot(q - r) / (p - r).cross(q - r).length();
                *weights.entry([a.min(b), a.max(b)]).or_insert(0.0) += 0.5 * cotangent;
            }
        }
        weights
    }

    #[test]
    fn on_good_meshes_it_is_the_cotangent_laplacian() {
        let sphere = shapes::icosphere(2);
        let laplacian = Laplacian::new(&sphere).unwrap();
        assert!((laplacian.mass.iter().sum::<f64>() - 4.0 * std::f64::consts::PI).abs() < 1.0);
        let naive = naive(&sphere);
        assert_eq!(laplacian.edges.len(), naive.len());
        for (edge, weight) in &laplacian.edges {
            assert!((weight - naive[edge]).abs() < 1e-9, "{edge:?} {weight} {}", naive[edge]);
        }
    }

    #[test]
    fn weights_are_positive_on_meshes_that_are_not_good() {
        let shapes = [shapes::plate(12, 0.01), shapes::bolt(24), shapes::moebius_strip(20, 3)];
        for mesh in shapes.iter().chain(&[shapes::tetrahedra_sharing_edge(), shapes::klein_bottle(20, 8)]) {
            let laplacian = Laplacian::new(mesh).unwrap();
            assert!(laplacian.edges.iter().all(|&(_, weight)| weight > -1e-7));
            assert!(laplacian.mass.iter().all(|&mass| mass > 0.0));
        }
    }

    #[test]
    fn faces_without_area_and_vertices_without_faces_are_no_trouble() {
        let positions = vec![[9.0; 3], [0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [2.0, 0.0, 0.0]];
        let laplacian = Laplacian::new(&TriMesh::new(positions, vec![[1, 2, 3], [1, 2, 4]]).unwrap()).unwrap();
        assert_eq!(laplacian.vertices, [1, 2, 3, 4]);
        assert!(laplacian.edges.iter().all(|(_, weight)| weight.is_finite()));
        assert!((laplacian.mass.iter().sum::<f64>() - 0.5).abs() < 1e-2);
        let points = TriMesh::new(vec![[1.0; 3]; 3], vec![[0, 1, 2]]).unwrap();
        assert!(Laplacian::new(&points).is_none() && Laplacian::new(&TriMesh::default()).is_none());
    }

    #[test]
    fn components_are_separated() {
        let boxes = Laplacian::new(&shapes::many_boxes(3)).unwrap();
        let mut components = boxes.component.clone();
        components.dedup();
        assert_eq!(components.len(), 3);
    }
}
