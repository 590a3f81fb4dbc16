//! How much more than its area each vertex counts, from the network's scores: where the collapse is to leave more
//! vertices.
//!
//! The quadrics alone ask for the least sum of squared distances. What looks right asks for more where the surface
//! bends and less where it is smooth; by how much is what the Point Sampler learns (Sec. 3.1). Importance multiplies
//! the quadrics once the darts are thrown, so that cuts and collapse follow it.

use std::sync::Arc;

use crate::linalg::{Csr, Stars};
use crate::mesh::pulse::Pulse;
use crate::mesh::shares::add_to_rows;
use crate::model::{Weights, star_scores, surface_scores};

use super::assignment::Assignment;
use crate::simplify::closed::prepare::surface::Surface;
use crate::simplify::closed::request::Importance;

/// Scores farther than this from their mean count as if they were not. It bounds the importance at 33 times the mean
/// for any network; the shipped weights stay within 2 on sixteen training meshes.
const MOST_SCORE: f32 = 3.5;
/// Vertices whose edges stand for all in the mean length: 12,000 edges tell it within 1 %. Sixteen training meshes: the
/// mean distance moves by 0.2 % with 256 vertices or with all, as with another order of the vertices.
const MEASURED: usize = 2048;
/// Vertices per region from which on the sample's score stands for all of them. Twelve large training meshes at ratios
/// 0.03 to 0.15: at 1 and at 16 the mean distance is 0.1 % farther; fewer scores take less time.
const LARGE: usize = 4;
/// Vertices that are scored between two beats: at less than a microsecond each, about ten milliseconds on one thread.
const TOGETHER: usize = 1 << 14;

/// How much a hidden vertex counts beside one that shows: as n regions of a surface are wrong by n^-2, it keeps a tenth of its vertices.
pub const HIDDEN: f32 = 1e-3;

/// Weighs the vertices of a surface; of a network's scores so much counts, of what is hidden little.
pub fn weigh(surface: &mut Surface, assignment: &Assignment, importance: Importance, strength: f32, hidden: &[bool]) {
    let mut factors = match importance {
        Importance::Even if hidden.is_empty() => return,
        Importance::Even => vec![1.0; surface.n_vertices()],
        Importance::Network(weights) => importance_of_regions(surface, assignment, weights, strength)
            .unwrap_or_else(|| importance_of_scores(&weakened(scores(surface, weights), strength), &areas(surface))),
        Importance::Given(factors) => surface.sources().map(|v| factors[v as usize]).collect(),
    };
    surface.pulse.beat(0);
    if !hidden.is_empty() {
        let of_hidden = factors.iter_mut().zip(surface.sources()).filter(|(_, v)| hidden[*v as usize]);
        of_hidden.for_each(|(factor, _)| *factor *= HIDDEN);
    }
    surface.weigh(factors);
}

/// The importance of each vertex by the score of its sample where regions are large, by its own elsewhere, n_vertices;
/// `None` for a network that sees more than neighbours.
fn importance_of_regions(
    surface: &Surface,
    assignment: &Assignment,
    weights: &Weights,
    strength: f32,
) -> Option<Vec<f32>> {
    if surface.n_vertices() < LARGE * assignment.samples.len() {
        return importance_of_stars(surface, &Assignment::identity(surface.n_vertices()), weights, strength);
    }
    importance_of_stars(surface, assignment, weights, strength)
}

/// The importance of the regions: means over their vertices by area; none where all count alike.
pub fn of_regions(surface: &Surface, assignment: &Assignment) -> Vec<f32> {
    if surface.importance.is_empty() {
        return Vec::new();
    }
    let mut sums = vec![[0.0f64; 2]; assignment.n_regions];
    add_to_rows(surface.pulse, &mut sums, &assignment.region, |[weight, area], v| {
        *weight += surface.weight(v);
        *area += surface.weight(v) / f64::from(surface.importance[v]);
    });
    surface.pulse.map(&sums, |[weight, area]| (weight / area) as f32)
}

/// The importance of each vertex by the score of its sample, n_vertices.
fn importance_of_stars(
    surface: &Surface,
    assignment: &Assignment,
    weights: &Weights,
    strength: f32,
) -> Option<Vec<f32>> {
    let scores = scores_of(surface, &assignment.samples, weights)?;
    let mut areas = vec![0.0; assignment.n_regions];
    add_to_rows(surface.pulse, &mut areas, &assignment.region, |area, v| *area += surface.weight(v));
    let factors = importance_with(surface.pulse, &weakened(scores, strength), &areas);
    surface.pulse.beat(0);
    Some(surface.pulse.map(&assignment.region, |&r| factors[r as usize]))
}

/// What of the scores counts.
fn weakened(mut scores: Vec<f32>, strength: f32) -> Vec<f32> {
    scores.iter_mut().for_each(|score| *score *= strength);
    scores
}

/// The scores of some vertices.
fn scores_of(surface: &Surface, vertices: &[u32], weights: &Weights) -> Option<Vec<f32>> {
    let edge_length = mean_edge_length(surface);
    let mut scores = Vec::with_capacity(vertices.len());
    for numbers in surface.pulse.by(TOGETHER, 0..vertices.len()) {
        let vertices = &vertices[numbers];
        let star = |i: usize| (vertices[i] as usize, surface.neighbors(vertices[i]));
        let stars = Stars { x: [&surface.positions, &surface.normals], n: vertices.len(), of: star };
        scores.extend(star_scores(weights, &stars, edge_length)?);
    }
    Some(scores)
}

/// The mean length of the edges, of a part of them on a large surface; 1 where they have none.
fn mean_edge_length(surface: &Surface) -> f32 {
    let (mut sum, mut n_edges) = (0.0, 0u32);
    for v in (0..surface.n_vertices()).step_by(surface.n_vertices() / MEASURED + 1) {
        for &w in surface.neighbors(v as u32) {
            sum += f64::from(surface.positions[v].distance(surface.positions[w as usize]));
            n_edges += 1;
        }
    }
    if sum > 0.0 { (sum / f64::from(n_edges)) as f32 } else { 1.0 }
}

/// The scores of all vertices, n_vertices.
fn scores(surface: &Surface, weights: &Weights) -> Vec<f32> {
    let rings = Arc::new(edges(surface));
    surface_scores(weights, &surface.positions, &surface.normals, &rings)
}

/// The rings as sparse rows, ghost vertices left out.
fn edges(surface: &Surface) -> Csr {
    Csr::from_neighbours(surface.n_vertices(), |v| surface.neighbors(v as u32))
}

/// By how much more than its area each vertex counts, from its score: the exponential of the score about the mean by area.
///
/// Only differences of scores matter. Weights of a network may be so large that a score is not finite: it then counts as 0.
///
/// # Shapes
/// - `scores` and `areas` (0 or more): n
/// - returns n positive factors
///
/// ```
/// use neural_mesh::simplify::importance_of_scores;
/// let factors = importance_of_scores(&[1.0, 3.0], &[1.0, 1.0]);
/// assert!((factors[1] / factors[0] - 2.0_f32.exp()).abs() < 1e-5);
/// ```
pub fn importance_of_scores(scores: &[f32], areas: &[f64]) -> Vec<f32> {
    importance_with(Pulse::NONE, scores, areas)
}

/// As [`importance_of_scores`], where someone may listen.
fn importance_with(pulse: Pulse, scores: &[f32], areas: &[f64]) -> Vec<f32> {
    let total: f64 = areas.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    let finite = |s: f32| if s.is_finite() { s } else { 0.0 };
    let mean = scores.iter().zip(areas).map(|(&s, area)| area * f64::from(finite(s))).sum::<f64>() / total;
    pulse.counting_if(false).map(scores, |&s| (finite(s) - mean as f32).clamp(-MOST_SCORE, MOST_SCORE).exp())
}

/// The weights of the vertices as long as all count alike, n_vertices.
fn areas(surface: &Surface) -> Vec<f64> {
    (0..surface.n_vertices()).map(|v| surface.weight(v)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::simplify::{edge_graph, network_scores};

    #[test]
    fn scores_are_those_of_the_mesh() {
        let mesh = shapes::wavy_sphere(3, 5.0);
        let surface = Surface::new(&mesh, Pulse::NONE);
        assert_eq!(edges(&surface), edge_graph(&mesh));
        let weights = Weights::random(1);
        for (own, of_mesh) in scores(&surface, &weights).iter().zip(network_scores(&mesh, &weights)) {
            assert!((own - of_mesh).abs() < 1e-3, "{own} {of_mesh}");
        }
    }

    #[test]
    fn scores_of_some_vertices_are_those_of_the_mesh() {
        for mesh in [shapes::wavy_sphere(3, 5.0), shapes::grid(9, 7)] {
            let surface = Surface::new(&mesh, Pulse::NONE);
            let samples = [5, 0, 17, 33];
            let weights = Weights::shipped_default();
            let own = scores_of(&surface, &samples, weights).unwrap();
            let of_mesh = scores(&surface, weights);
            for (score, v) in own.iter().zip(samples) {
                assert!((score - of_mesh[v as usize]).abs() < 1e-2, "{score} {}", of_mesh[v as usize]);
            }
            assert_eq!(scores_of(&surface, &samples, &Weights::random(1)), None);
        }
    }

    #[test]
    fn vertices_of_large_regions_count_as_their_sample_does() {
        let mesh = shapes::wavy_sphere(3, 5.0);
        let n = mesh.positions().len();
        let weighed = |n_regions: usize| {
            let mut surface = Surface::new(&mesh, Pulse::NONE);
            let region = (0..n).map(|v| (v % n_regions) as u32).collect();
            let assignment = Assignment { region, n_regions, samples: (0..n_regions as u32).collect() };
            weigh(&mut surface, &assignment, Importance::Network(Weights::shipped_default()), 0.7, &[]);
            surface.importance
        };
        let (coarse, fine, own) = (weighed(n / LARGE), weighed(n / LARGE + 1), weighed(n));
        assert!((0..n).all(|v| coarse[v] == coarse[v % (n / LARGE)]));
        assert!((0..n).any(|v| coarse[v] != coarse[0]));
        assert_eq!(fine, own);
    }

    #[test]
    fn importance_multiplies_quadrics() {
        let mesh = shapes::grid(5, 5);
        let (plain, mut heavy) = (Surface::new(&mesh, Pulse::NONE), Surface::new(&mesh, Pulse::NONE));
        weigh(&mut heavy, &Assignment::identity(36), Importance::Given(&[2.0; 36]), 0.7, &[]);
        assert!((0..36).all(|v| heavy.weight(v) == 2.0 * plain.weight(v)));
        let (mut half, hidden) = (Surface::new(&mesh, Pulse::NONE), [[false; 18], [true; 18]].concat());
        weigh(&mut half, &Assignment::identity(36), Importance::Even, 0.7, &hidden);
        assert!((0..36).all(|v| half.importance[v] == if v < 18 { 1.0 } else { HIDDEN }));
        let even = importance_of_scores(&[7.0; 36], &areas(&plain));
        assert!(even.iter().all(|factor| (factor - 1.0).abs() < 1e-5));
        let spread: Vec<f32> = (0..36).map(|v| if v == 0 { 100.0 } else { 0.0 }).collect();
        assert!(importance_of_scores(&spread, &areas(&plain))[0] <= MOST_SCORE.exp());
        let wild: Vec<f32> = (0..36).map(|v| [1.0, f32::NAN, f32::INFINITY][v % 3]).collect();
        assert!(importance_of_scores(&wild, &areas(&plain)).iter().all(|factor| factor.is_finite() && *factor > 0.0));
    }
}
