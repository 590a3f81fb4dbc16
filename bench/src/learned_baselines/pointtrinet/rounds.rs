//! The rounds: classify candidates, propose new ones.

use super::Candidates;
use super::classifier::classifier;
use super::patches::CandidateNeighbourhoods;
use super::proposals::{Draw, point_probabilities, proposals};
use neural_mesh::autodiff::{Tape, Tensors, Value};

/// Number of rounds; the last one only classifies.
pub const ROUNDS: usize = 5;
// Triangles with a higher probability are faces.
const THRESHOLD: f32 = 0.9;
// Queries per batch, which bounds the memory.
const CHUNK: usize = 1024;

/// Returns the triangles with probability above 0.9 after five rounds.
///
/// # Shapes
/// - `vertices`: n x 3, finite; `tensors`: constants
/// - returns n_faces x 3 with ascending corners
pub fn triangulate(tensors: &Tensors<Value>, vertices: &[[f32; 3]], seed: u64) -> Vec<[u32; 3]> {
    let candidates = last_candidates(tensors, vertices, Draw { seed, random_share: 0.0 });
    let neighbourhoods = CandidateNeighbourhoods::new(vertices, &candidates);
    let mut faces = Vec::new();
    for queries in chunks(candidates.triangles.len()) {
        let tape = &mut Tape::default();
        let p = classifier(tape, tensors, &neighbourhoods, &queries);
        let likely = queries.iter().zip(p.matrix().data()).filter(|(_, p)| **p > THRESHOLD);
        faces.extend(likely.map(|(&query, _)| candidates.triangles[query as usize]));
    }
    faces
}

/// Returns the candidates before the last classification.
pub fn last_candidates(tensors: &Tensors<Value>, vertices: &[[f32; 3]], draw: Draw) -> Candidates {
    let mut candidates = Candidates::seeds(vertices);
    for round in 1..ROUNDS as u64 {
        // Seeds are spaced so that every edge of every round has its own.
        let seed = draw.seed.wrapping_add(round << 40);
        candidates = run_round(tensors, vertices, candidates, Draw { seed, ..draw });
    }
    candidates
}

fn run_round(tensors: &Tensors<Value>, vertices: &[[f32; 3]], before: Candidates, draw: Draw) -> Candidates {
    let neighbourhoods = CandidateNeighbourhoods::new(vertices, &before);
    let (mut probabilities, mut proposed) = (Vec::new(), Vec::new());
    for queries in chunks(before.triangles.len()) {
        let tape = &mut Tape::default();
        let p = classifier(tape, tensors, &neighbourhoods, &queries);
        let of_points = point_probabilities(tape, tensors, &neighbourhoods, &queries);
        let [p, of_points] = [p.matrix().data(), of_points.matrix().data()];
        let new = proposals(&neighbourhoods, &queries, p, of_points, draw);
        proposed.extend(new.iter().map(|proposal| (proposal.triangle, proposal.probability)));
        probabilities.extend_from_slice(p);
    }
    Candidates { probabilities, ..before }.add(proposed, vertices.len())
}

fn chunks(n: usize) -> impl Iterator<Item = Vec<u32>> {
    (0..n).step_by(CHUNK).map(move |begin| (begin as u32..(begin + CHUNK).min(n) as u32).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learned_baselines::LearnedBaseline;
    use crate::linalg::test_values::run_on_threads;

    #[test]
    fn the_same_bits_on_any_number_of_threads() {
        let sphere = neural_mesh::mesh::shapes::wavy_sphere(1, 4.0);
        let tensors = LearnedBaseline::PointTriNet.initial_tensors(1.0 / 16.0, 1).constants();
        let draw = Draw { seed: 3, random_share: 0.25 };
        let on_threads = |n| run_on_threads(n, || last_candidates(&tensors, sphere.positions(), draw));
        let one = on_threads(1);
        assert_eq!(one, on_threads(3));
        assert!(one.triangles.len() > 4 * sphere.positions().len(), "{}", one.triangles.len());
        assert!(one.triangles.iter().all(|&[a, b, c]| a < b && b < c));
        assert_ne!(one, last_candidates(&tensors, sphere.positions(), Draw { seed: 4, ..draw }));
    }

    #[test]
    fn few_points_are_no_trouble() {
        let tensors = LearnedBaseline::PointTriNet.initial_tensors(1.0 / 16.0, 1).constants();
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 1.0]];
        for n in 0..5 {
            let found = last_candidates(&tensors, &points[..n], Draw { seed: 0, random_share: 0.0 });
            assert_eq!(found.triangles.len(), [0, 0, 0, 1, 4][n]);
            triangulate(&tensors, &points[..n], 0);
        }
        triangulate(&tensors, &[[1.0; 3]; 9], 0);
        // Untrained networks are sure of nothing.
        let sphere = neural_mesh::mesh::shapes::icosphere(1);
        assert!(
            triangulate(&LearnedBaseline::PointTriNet.initial_tensors(0.1, 1).constants(), sphere.positions(), 0).len()
                < 42
        );
    }
}
