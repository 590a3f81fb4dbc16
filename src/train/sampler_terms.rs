//! What the Point Sampler is judged by, Eq. (6): how well the vertices are covered by the samples that its scores draw, and what
//! else the samples are to keep.

use super::Settings;
use super::random::below;
use crate::linalg::Csr;
use crate::loss::{
    NamedTerm, Term, bending_of_samples, coverage_of_samples, curvature_of_samples, inclusion, inclusion_gradient,
    probabilistic_chamfer, smoothness,
};
use crate::simplify::gumbel_top_k;
use crate::spatial::{nearest_to, point_curvature};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::Rng;

/// Vertices at which the coverage is measured in one step.
const QUERIES: usize = 1024;
/// Neighbours of each that are looked at: so many times the vertices per sample, within bounds.
const NEIGHBOURS: (f64, f64, f64) = (5.0, 8.0, 128.0);

/// The vertices of a mesh as the Point Sampler sees them.
pub(super) struct Surface<'a> {
    /// n x 3, in edge lengths.
    pub points: &'a [[f32; 3]],
    /// n x 3, unit vectors.
    pub normals: &'a [[f32; 3]],
    /// n x n, the edges.
    pub rings: &'a Csr,
}

/// The terms of the scores that have a weight in the settings.
pub(super) fn sampler_terms(
    surface: &Surface,
    scores: &[f32],
    n_samples: usize,
    settings: &Settings,
    random: &mut Xoshiro256PlusPlus,
) -> Vec<NamedTerm> {
    let points = surface.points;
    let seed = random.next_u64();
    if settings.literal {
        let term = || literal(points, scores, n_samples, seed);
        return weighed([("chamfer", settings.lambda_sampler, &term)]);
    }
    let queries: Vec<u32> = (0..QUERIES.min(points.len())).map(|_| below(random, points.len()) as u32).collect();
    let (share, least, most) = NEIGHBOURS;
    let k = (share * points.len() as f64 / n_samples as f64).clamp(least, most) as usize;
    let places: Vec<[f32; 3]> = queries.iter().map(|&v| points[v as usize]).collect();
    let nearest = nearest_to(points, &places, k);
    let included = inclusion(scores, n_samples);
    let pi = &included.probabilities;
    let to_scores = |term: Term| Term { value: term.value, gradient: inclusion_gradient(&included, &term.gradient) };
    let coverage = || to_scores(coverage_of_samples(points, &places, &nearest, pi));
    let bending = || to_scores(bending_of_samples(points, surface.normals, &queries, &nearest, pi));
    let curvature = || {
        let of_points = point_curvature(points);
        let of_queries: Vec<f32> = queries.iter().map(|&v| of_points[v as usize]).collect();
        to_scores(curvature_of_samples(&of_queries, &of_points, &nearest, pi))
    };
    weighed([
        ("sampler", settings.lambda_sampler, &coverage),
        ("bending", settings.lambda_bending, &bending),
        ("curvature", settings.lambda_curvature, &curvature),
        ("smoothness", settings.lambda_smoothness, &|| smoothness(scores, surface.rings)),
    ])
}

/// The terms whose weight is not 0; no other is computed.
fn weighed<const N: usize>(terms: [(&'static str, f64, &dyn Fn() -> Term); N]) -> Vec<NamedTerm> {
    let of_weight = terms.into_iter().filter(|(_, weight, _)| *weight != 0.0);
    of_weight.map(|(name, weight, term)| NamedTerm { name, weight, term: term() }).collect()
}

/// Eq. (6) as printed: softmax probabilities of a drawn set, weighed with distances.
fn literal(points: &[[f32; 3]], scores: &[f32], n_samples: usize, seed: u64) -> Term {
    let probabilities = softmax(scores);
    let samples = gumbel_top_k(scores, n_samples, seed);
    let at = |v: &u32| points[*v as usize];
    let of_samples: Vec<f32> = samples.iter().map(|&v| probabilities[v as usize]).collect();
    let term = probabilistic_chamfer(points, &samples.iter().map(at).collect::<Vec<_>>(), &of_samples);
    let mut gradient = vec![0.0f32; scores.len()];
    samples.iter().zip(&term.gradient).for_each(|(&v, g)| gradient[v as usize] = *g);
    let mean: f64 = gradient.iter().zip(&probabilities).map(|(g, p)| f64::from(*g) * f64::from(*p)).sum();
    let through_softmax = gradient.iter().zip(&probabilities).map(|(g, p)| p * (g - mean as f32));
    Term { value: term.value, gradient: through_softmax.collect() }
}

fn softmax(scores: &[f32]) -> Vec<f32> {
    let largest = scores.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let rates: Vec<f64> = scores.iter().map(|s| f64::from(s - largest).exp()).collect();
    let sum: f64 = rates.iter().sum();
    rates.iter().map(|rate| (rate / sum) as f32).collect()
}
