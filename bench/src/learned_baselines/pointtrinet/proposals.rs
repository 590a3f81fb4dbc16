//! The proposal network.

use super::classifier::pool;
use super::network::{DEPTH, SCORE_DEPTH};
use super::patches::{CandidateNeighbourhoods, point_features};
use crate::learned_baselines::{layers, tensor};
use neural_mesh::autodiff::{Tape, Tensors, Value};
use neural_mesh::parallel;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

const PER_EDGE: usize = 4;
// Number added to the probabilities of a draw, so that any point can be drawn.
const LEAST: f32 = 1e-4;

/// A triangle proposed by an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proposal {
    /// Corners in ascending order.
    pub triangle: [u32; 3],
    /// Probability of the point times that of the triangle.
    pub probability: f32,
    /// Index of the proposing triangle among the queries.
    pub query: u32,
    /// Row of the point in [`point_probabilities`].
    pub row: u32,
}

/// Returns the probability of each near point as third corner over each edge.
///
/// # Shapes
/// - `queries`: indices of n candidates
/// - returns (n * 3 * n_points) x 1, edge by edge
pub fn point_probabilities(
    tape: &mut Tape,
    tensors: &Tensors<Value>,
    neighbourhoods: &CandidateNeighbourhoods,
    queries: &[u32],
) -> Value {
    let edges = |&q: &u32| {
        rotations(neighbourhoods.candidates.triangles[q as usize])
            .map(|triangle| (triangle, neighbourhoods.nearest_points(q as usize)))
    };
    let features = point_features(neighbourhoods.vertices, &queries.iter().flat_map(edges).collect::<Vec<_>>());
    let n_edges = 3 * queries.len();
    let of_edges = pool(tape, features.clone(), &layers(tensors, "proposals.points", DEPTH), n_edges);
    let of_edges = tape.product(&of_edges, tensor(tensors, "proposals.pooled"));
    let logits = tape.layers_with_group_rows(
        &Value::constant(features),
        &of_edges,
        &layers(tensors, "proposals.score", SCORE_DEPTH),
        neighbourhoods.n_points,
    );
    tape.sigmoid(&logits)
}

fn rotations([a, b, c]: [u32; 3]) -> [[u32; 3]; 3] {
    [[a, b, c], [b, c, a], [c, a, b]]
}

/// Settings of the random proposals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Draw {
    /// Seed of the draws.
    pub seed: u64,
    /// Fraction of the draws that ignore the probabilities.
    pub random_share: f32,
}

/// Draws four distinct points per edge by probability, without the triangle's own corners.
///
/// # Shapes
/// - `of_queries`: n; `of_points`: from [`point_probabilities`]
/// - returns the proposals by query and edge
pub fn proposals(
    neighbourhoods: &CandidateNeighbourhoods,
    queries: &[u32],
    of_queries: &[f32],
    of_points: &[f32],
    draw: Draw,
) -> Vec<Proposal> {
    let k = neighbourhoods.n_points;
    let of_edge = |(edge, query): (usize, usize)| {
        let candidate = queries[query] as usize;
        let near = neighbourhoods.nearest_points(candidate);
        let triangle = rotations(neighbourhoods.candidates.triangles[candidate])[edge % 3];
        let rows = &of_points[edge * k..][..k];
        let random =
            Xoshiro256PlusPlus::seed_from_u64(draw.seed.wrapping_add(u64::from(queries[query]) * 3 + edge as u64 % 3));
        draw_points(near, triangle, rows, draw.random_share, random).into_iter().map(move |place| {
            let mut corners = [triangle[0], triangle[1], near[place]];
            corners.sort_unstable();
            let probability = rows[place] * of_queries[query];
            Proposal { triangle: corners, probability, query: query as u32, row: (edge * k + place) as u32 }
        })
    };
    parallel::flat_map(0..3 * queries.len(), 64, |edge| of_edge((edge, edge / 3))).collect()
}

fn draw_points(
    near: &[u32],
    own: [u32; 3],
    p: &[f32],
    random_share: f32,
    mut random: Xoshiro256PlusPlus,
) -> Vec<usize> {
    let mean = p.iter().sum::<f32>() / p.len() as f32 + LEAST;
    let mut keys: Vec<(f64, usize)> = Vec::with_capacity(near.len());
    for (place, (point, p)) in near.iter().zip(p).enumerate() {
        let uniform = ((random.next_u64() >> 11) as f64 + 0.5) / (1u64 << 53) as f64;
        if !own.contains(point) {
            let weight = random_share * mean + (1.0 - random_share) * (p + LEAST);
            // The largest keys are a weighted draw without replacement (Efraimidis and Spirakis 2006).
            keys.push((uniform.ln() / f64::from(weight), place));
        }
    }
    let n = PER_EDGE.min(keys.len());
    keys.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    keys[..n].iter().map(|&(_, place)| place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_drawn_by_their_weights_once_and_never_the_corners() {
        let near: Vec<u32> = (10..20).collect();
        let p: Vec<f32> = (0..10).map(|i| if i < 5 { 0.8 } else { 0.2 }).collect();
        let mut counts = [0; 10];
        for seed in 0..2000 {
            let mut found = draw_points(&near, [10, 19, 3], &p, 0.0, Xoshiro256PlusPlus::seed_from_u64(seed));
            counts[found[0]] += 1;
            found.sort_unstable();
            found.dedup();
            assert_eq!(found.len(), 4);
        }
        assert_eq!([counts[0], counts[9]], [0, 0]);
        assert!(counts[1..5].iter().all(|n| (340..500).contains(n)), "{counts:?}");
        assert!(counts[5..9].iter().all(|n| (60..160).contains(n)), "{counts:?}");
        assert_eq!(draw_points(&[1, 2, 3, 4], [1, 2, 3], &[0.5; 4], 0.25, Xoshiro256PlusPlus::seed_from_u64(1)), [3]);
    }
}
