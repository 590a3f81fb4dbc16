//! What the Point Sampler is judged by, Eq. (6): how well the vertices are covered by the samples that its scores draw.

use super::Settings;
use super::random::below;
use crate::loss::{NamedTerm, Term, coverage_of_samples, inclusion, inclusion_gradient, probabilistic_chamfer};
use crate::simplify::gumbel_top_k;
use crate::spatial::nearest_to;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::Rng;

/// Vertices at which the coverage is measured in one step.
const QUERIES: usize = 1024;
/// Neighbours of each that are looked at: so many times the vertices per sample, within bounds.
const NEIGHBOURS: (f64, f64, f64) = (5.0, 8.0, 128.0);

/// The terms of the scores that have a weight in the settings.
pub(super) fn sampler_terms(
    points: &[[f32; 3]],
    scores: &[f32],
    n_samples: usize,
    settings: &Settings,
    random: &mut Xoshiro256PlusPlus,
) -> Vec<NamedTerm> {
    let weight = settings.lambda_sampler;
    if weight == 0.0 {
        return Vec::new();
    }
    let (name, term) = match settings.literal {
        true => ("chamfer", literal(points, scores, n_samples, random.next_u64())),
        false => ("sampler", relaxed(points, scores, n_samples, random)),
    };
    vec![NamedTerm { name, weight, term }]
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

/// The form that trains: the expected distance to the nearest sample, at some of the vertices.
fn relaxed(points: &[[f32; 3]], scores: &[f32], n_samples: usize, random: &mut Xoshiro256PlusPlus) -> Term {
    let queries: Vec<[f32; 3]> = (0..QUERIES.min(points.len())).map(|_| points[below(random, points.len())]).collect();
    let (share, least, most) = NEIGHBOURS;
    let k = (share * points.len() as f64 / n_samples as f64).clamp(least, most) as usize;
    let nearest = nearest_to(points, &queries, k);
    let included = inclusion(scores, n_samples);
    let term = coverage_of_samples(points, &queries, &nearest, &included.probabilities);
    Term { value: term.value, gradient: inclusion_gradient(&included, &term.gradient) }
}
