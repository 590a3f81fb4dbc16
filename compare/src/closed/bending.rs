//! An importance made by a formula, from how much the surface bends: what learned scores have to beat.

use neural_mesh::mesh::TriMesh;
use neural_mesh::model::in_edge_lengths;
use neural_mesh::simplify::{bending_scores, edge_graph, vertex_areas, vertex_normals};

/// The square root of the bending about each vertex over its mean by area: the exponentials of [`bending_scores`]. All ones
/// where nothing bends.
pub fn bending_importance(mesh: &TriMesh) -> Vec<f32> {
    let rings = edge_graph(mesh);
    let points = in_edge_lengths(mesh.positions(), &rings);
    let scores = bending_scores(&points, &vertex_normals(mesh), &vertex_areas(mesh), &rings);
    scores.map_or(vec![1.0; points.len()], |scores| scores.into_iter().map(f32::exp).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use neural_mesh::mesh::shapes;

    #[test]
    fn edges_count_more_than_planes() {
        let mesh = shapes::cuboid([1.0; 3], 8);
        let importance = bending_importance(&mesh);
        let at = |wanted: [f32; 3]| mesh.positions().iter().position(|&p| p == wanted).unwrap();
        assert!((importance[at([0.5, 0.5, 0.0])] - 0.1f32.sqrt()).abs() < 1e-6);
        assert!(importance[at([0.0; 3])] > 1.2);
        assert!(bending_importance(&shapes::grid(5, 5)).iter().all(|&x| x == 1.0));
    }
}
