//! The paper's assembly, Sec. 4: faces of probability above one half, of these the two likeliest per edge, wound like
//! the original.

use super::Quotient;
use crate::geometry::triangle::area_normal_f64;
use crate::model::PredictedFaces;
use glam::{DVec3, Vec3};

/// Chooses candidates of probability above 0.5 that are among the two likeliest on all three of their edges.
///
/// If two are equally likely, the first is better.
///
/// # Shapes
/// - `n_entries`: number of entries of G_ext
/// - returns indices of candidates, ascending
///
/// ```
/// # use neural_mesh_simplify as neural_mesh;
/// use neural_mesh::{linalg::Csr, model::{PredictedFaces, candidate_faces}, simplify::paper::choose_faces};
/// // Three triangles over the edge 0-1: the least likely of them goes.
/// let graph = Csr::from_edges(5, [[0, 1], [0, 2], [1, 2], [0, 3], [1, 3], [0, 4], [1, 4]]);
/// let candidates = candidate_faces(&graph, &[1.0; 14], &[]);
/// let faces = PredictedFaces { candidates, prior: vec![1.0; 3], probabilities: vec![0.6, 0.9, 0.7] };
/// assert_eq!(choose_faces(&faces, 14), [1, 2]);
/// ```
pub fn choose_faces(faces: &PredictedFaces, n_entries: usize) -> Vec<usize> {
    let probabilities = &faces.probabilities;
    let mut ranked: Vec<usize> = (0..probabilities.len()).filter(|&at| probabilities[at] > 0.5).collect();
    ranked.sort_unstable_by(|&a, &b| probabilities[b].total_cmp(&probabilities[a]).then(a.cmp(&b)));
    let mut n_better = vec![0u8; n_entries];
    ranked.retain(|&at| {
        let edges = faces.candidates.entries[at].map(|entry| entry as usize);
        let is_among_best = edges.iter().all(|&edge| n_better[edge] < 2);
        edges.iter().for_each(|&edge| n_better[edge] = n_better[edge].saturating_add(1));
        is_among_best
    });
    ranked.sort_unstable();
    ranked
}

/// Winds a triangle like the mesh faces that span its three regions, or else by the normals of these regions.
///
/// # Shapes
/// - `positions`: n_samples x 3
/// - `triangle`: samples, ascending
///
/// ```
/// # use neural_mesh_simplify as neural_mesh;
/// use neural_mesh::simplify::paper::{orient_triangle, quotient};
/// let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let between = quotient(&positions, &[[0, 2, 1]], &[0, 1, 2], 3);
/// assert_eq!(orient_triangle([0, 1, 2], &positions, &between), [0, 2, 1]);
/// ```
pub fn orient_triangle(triangle: [u32; 3], positions: &[[f32; 3]], quotient: &Quotient) -> [u32; 3] {
    let [i, j, k] = triangle;
    let inherited = quotient.triangles.binary_search(&triangle).map_or(0, |at| quotient.windings[at]);
    let is_against = match inherited {
        0 => {
            let normal = area_normal_f64(triangle.map(|v| Vec3::from(positions[v as usize]).as_dvec3()));
            let nearby: DVec3 = triangle.iter().map(|&v| quotient.normals[v as usize]).sum();
            normal.dot(nearby) < 0.0
        }
        windings => windings < 0,
    };
    if is_against { [i, k, j] } else { triangle }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::Csr;
    use crate::model::candidate_faces;
    use crate::simplify::paper::quotient;

    #[test]
    fn the_third_face_on_an_edge_is_dropped_even_if_a_better_one_is_too() {
        // Fans around the edges 0-1 and 2-3; [0, 1, 2] loses on 0-1 and still counts on its other edges.
        let all = (0..6).flat_map(|i| (i + 1..6).map(move |j| [i, j]));
        let graph = Csr::from_edges(6, all);
        let candidates = candidate_faces(&graph, &vec![1.0; graph.n_entries()], &[]);
        let p = |triangle: &[u32; 3]| match triangle {
            [0, 1, 3] | [0, 1, 4] => 0.9,
            [0, 1, 2] => 0.8,
            [1, 2, 5] => 0.7,
            [1, 2, 4] => 0.6,
            [0, 4, 5] => 0.5,
            _ => 0.1,
        };
        let probabilities: Vec<f32> = candidates.triangles.iter().map(p).collect();
        let faces = PredictedFaces { prior: probabilities.clone(), probabilities, candidates };
        let chosen = choose_faces(&faces, graph.n_entries());
        let chosen: Vec<[u32; 3]> = chosen.iter().map(|&at| faces.candidates.triangles[at]).collect();
        assert_eq!(chosen, [[0, 1, 3], [0, 1, 4], [1, 2, 5]]);
    }

    #[test]
    fn equally_likely_faces_are_taken_in_order() {
        let graph = Csr::from_edges(5, [[0, 1], [0, 2], [1, 2], [0, 3], [1, 3], [0, 4], [1, 4]]);
        let candidates = candidate_faces(&graph, &[1.0; 14], &[]);
        let faces = PredictedFaces { candidates, prior: vec![1.0; 3], probabilities: vec![0.75; 3] };
        assert_eq!(choose_faces(&faces, 14), [0, 1]);
    }

    #[test]
    fn triangles_turn_like_the_original() {
        let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
        let downward = quotient(&positions, &[[0, 2, 1], [1, 2, 3]], &[0, 1, 2, 3], 4);
        assert_eq!(orient_triangle([0, 1, 2], &positions, &downward), [0, 2, 1]);
        assert_eq!(orient_triangle([1, 2, 3], &positions, &downward), [1, 2, 3]);
        let downward = quotient(&positions, &[[0, 2, 1], [1, 2, 3], [0, 2, 3]], &[0, 1, 2, 3], 4);
        // Not a triangle of the mesh; the faces around point down on the whole.
        assert_eq!(orient_triangle([0, 1, 3], &positions, &downward), [0, 3, 1]);
    }
}
