//! Vertex quadrics from faces and open edges.

use crate::baselines::points::to_double;
use neural_mesh::geometry::Quadric;
use neural_mesh::geometry::triangle::area_normal_f64;
use neural_mesh::mesh::{TriMesh, edges};

// Weight of planes at open edges relative to that of faces, as in Open3D.
const BOUNDARY_WEIGHT: f64 = 1.0;

pub(super) fn quadrics(mesh: &TriMesh) -> Vec<Quadric> {
    let positions = to_double(mesh.positions());
    let mut quadrics = vec![Quadric::default(); positions.len()];
    let corners = |face: [u32; 3]| face.map(|v| positions[v as usize]);
    for &face in mesh.faces() {
        let normal = area_normal_f64(corners(face));
        let first = positions[face[0] as usize];
        let plane = Quadric::from_plane(normal.normalize_or_zero(), first, 0.5 * normal.length());
        face.iter().for_each(|&v| quadrics[v as usize] += plane);
    }
    for edge in edges(mesh).into_iter().filter(|edge| edge.n_faces() == 1) {
        let [v, w] = edge.ends;
        let normal = area_normal_f64(corners(mesh.faces()[edge.face as usize]));
        let along = positions[w as usize] - positions[v as usize];
        let across = normal.cross(along).normalize_or_zero();
        let plane = Quadric::from_plane(across, positions[v as usize], BOUNDARY_WEIGHT * 0.5 * normal.length());
        [v, w].iter().for_each(|&v| quadrics[v as usize] += plane);
    }
    quadrics
}
