//! Lengths and areas on a mesh, plain or longer where the surface bends: the metric of the closed assembly's darts.
//!
//! An edge e between vertices whose normals differ by dn has the squared length `|e|^2 + bend |e| |dn|`, with
//! lengths in diagonals of the bounding box.

use neural_mesh::geometry::triangle::area_normal_f64;
use neural_mesh::mesh::TriMesh;

/// The radius of curvature, in diagonals, at which bending counts as much as length in the darts' metric.
pub const BEND: f64 = 2.0;

/// Every vertex's share of the surface.
pub struct Cells {
    /// Area of each vertex's cell in the metric, n_vertices.
    pub areas: Vec<f64>,
    /// How many times larger than on the plain surface that is, n_vertices; at least 1.
    pub density: Vec<f64>,
}

impl Cells {
    pub fn new(mesh: &TriMesh, bend: f64) -> Self {
        let n = mesh.positions().len();
        let mut areas = vec![0.0; n];
        for face in mesh.faces() {
            let area = area_normal_f64(corners(mesh, face).map(Into::into)).length() / 6.0;
            face.iter().for_each(|&v| areas[v as usize] += area);
        }
        let (mut plain, mut bent) = (vec![0.0; n], vec![0.0; n]);
        for_each_edge(mesh, bend, &mut |[a, b], lengths2| {
            for v in [a as usize, b as usize] {
                plain[v] += lengths2[0];
                bent[v] += lengths2[1];
            }
        });
        let density: Vec<f64> = plain.iter().zip(&bent).map(|(&p, &b)| if p > 0.0 { b / p } else { 1.0 }).collect();
        areas.iter_mut().zip(&density).for_each(|(area, density)| *area *= density);
        Self { areas, density }
    }
}

/// The neighbours of each vertex and the lengths of the edges to them.
pub fn edge_lengths(mesh: &TriMesh, bend: f64) -> Vec<Vec<(u32, f64)>> {
    let mut edges = vec![Vec::new(); mesh.positions().len()];
    for_each_edge(mesh, bend, &mut |[a, b], lengths2| {
        edges[a as usize].push((b, lengths2[1].sqrt()));
        edges[b as usize].push((a, lengths2[1].sqrt()));
    });
    edges
}

/// Visits the three edges of each face with their squared lengths, plain and in the metric.
fn for_each_edge(mesh: &TriMesh, bend: f64, visit: &mut dyn FnMut([u32; 2], [f64; 2])) {
    let normals = vertex_normals(mesh);
    let bend = bend * diagonal(mesh.positions());
    for &[a, b, c] in mesh.faces() {
        for edge in [[a, b], [b, c], [c, a]] {
            let [p, q] = edge.map(|v| mesh.positions()[v as usize].map(f64::from));
            let [m, n] = edge.map(|v| normals[v as usize]);
            let plain = distance2(p, q);
            visit(edge, [plain, plain + bend * (plain * distance2(m, n)).sqrt()]);
        }
    }
}

fn vertex_normals(mesh: &TriMesh) -> Vec<[f64; 3]> {
    let mut normals = vec![[0.0; 3]; mesh.positions().len()];
    for face in mesh.faces() {
        let normal = area_normal_f64(corners(mesh, face).map(Into::into)).to_array();
        face.iter().for_each(|&v| (0..3).for_each(|k| normals[v as usize][k] += normal[k]));
    }
    let unit = |n: [f64; 3]| n.map(|x| x / distance2(n, [0.0; 3]).sqrt().max(f64::MIN_POSITIVE));
    normals.into_iter().map(unit).collect()
}

fn corners(mesh: &TriMesh, face: &[u32; 3]) -> [[f64; 3]; 3] {
    face.map(|v| mesh.positions()[v as usize].map(f64::from))
}

fn diagonal(points: &[[f32; 3]]) -> f64 {
    let bound = |pick: fn(f64, f64) -> f64, start: f64| {
        points.iter().fold([start; 3], |bound, p| [0, 1, 2].map(|k| pick(bound[k], f64::from(p[k]))))
    };
    distance2(bound(f64::min, f64::INFINITY), bound(f64::max, f64::NEG_INFINITY)).sqrt()
}

fn distance2(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use neural_mesh::mesh::shapes;

    #[test]
    fn a_sphere_bends_as_its_radius_says() {
        let sphere = shapes::icosphere(4);
        let plain = Cells::new(&sphere, 0.0);
        assert!((plain.areas.iter().sum::<f64>() / (4.0 * std::f64::consts::PI) - 1.0).abs() < 0.01);
        assert!(plain.density.iter().all(|d| (d - 1.0).abs() < 1e-12));
        let diagonal = diagonal(sphere.positions());
        let bent = Cells::new(&sphere, 2.0);
        let mean = bent.density.iter().sum::<f64>() / bent.density.len() as f64;
        assert!((mean / (1.0 + 2.0 * diagonal) - 1.0).abs() < 0.02, "{mean}");
    }
}
