//! Loss terms of the Point Sampler: Eq. (6) and additions.

use super::Settings;
use super::random::random_below;
use crate::autodiff::Tape;
use crate::linalg::{Csr, Matrix};
use crate::loss::{
    NamedTerm, Term, coverage_of_samples, curvature_of_samples, deviation_of_samples, inclusion, inclusion_gradient,
    probabilistic_chamfer, smoothness,
};
use crate::model::inclusion_probabilities;
use crate::simplify::gumbel_top_k;
use crate::spatial::{nearest_to, point_curvature};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::Rng;

/// Number of vertices per step, the queries, at which the terms are measured.
const QUERIES: usize = 1024;
/// Neighbours per query: as a multiple of the vertices per sample, the least, the most.
const NEIGHBOURS: (f64, f64, f64) = (5.0, 8.0, 128.0);

pub(super) struct SamplerInput<'a> {
    /// Vertex positions, n x 3, in mean edge lengths.
    pub points: &'a [[f32; 3]],
    /// Positions without noise, n x 3, in the same frame.
    pub originals: &'a [[f32; 3]],
    pub rings: &'a Csr,
}

pub(super) fn sampler_terms(
    surface: &SamplerInput,
    scores: &[f32],
    n_samples: usize,
    settings: &Settings,
    random: &mut Xoshiro256PlusPlus,
) -> Vec<NamedTerm> {
    let points = surface.points;
    let seed = random.next_u64();
    if settings.literal {
        let term = || printed_chamfer(points, scores, n_samples, seed);
        return compute_weighted([("chamfer", settings.lambda_sampler, &term)]);
    }
    let queries: Vec<u32> = (0..QUERIES.min(points.len())).map(|_| random_below(random, points.len()) as u32).collect();
    let (share, least, most) = NEIGHBOURS;
    let k = (share * points.len() as f64 / n_samples as f64).clamp(least, most) as usize;
    let places: Vec<[f32; 3]> = queries.iter().map(|&v| surface.originals[v as usize]).collect();
    let nearest = nearest_to(points, &places, k);
    let included = inclusion(scores, n_samples);
    let pi = &included.probabilities;
    let to_scores = |term: Term| Term { value: term.value, gradient: inclusion_gradient(&included, &term.gradient) };
    let coverage = || to_scores(coverage_of_samples(points, &places, &nearest, pi));
    let deviation = || to_scores(deviation_of_samples(points, surface.originals, (&places, &nearest), pi));
    // Without noise all vertices are on the original.
    let lambda_deviation = if settings.noise > 0.0 { settings.lambda_sampler } else { 0.0 };
    let curvature = || {
        let of_points = point_curvature(points);
        let of_queries: Vec<f32> = queries.iter().map(|&v| of_points[v as usize]).collect();
        to_scores(curvature_of_samples(&of_queries, &of_points, &nearest, pi))
    };
    compute_weighted([
        ("sampler", settings.lambda_sampler, &coverage),
        ("deviation", lambda_deviation, &deviation),
        ("curvature", settings.lambda_curvature, &curvature),
        ("smoothness", settings.lambda_smoothness, &|| smoothness(scores, surface.rings)),
    ])
}

fn compute_weighted<const N: usize>(terms: [(&'static str, f64, &dyn Fn() -> Term); N]) -> Vec<NamedTerm> {
    let of_weight = terms.into_iter().filter(|(_, weight, _)| *weight != 0.0);
    of_weight.map(|(name, weight, term)| NamedTerm { name, weight, term: term() }).collect()
}

/// Computes Eq. (6) as printed.
fn printed_chamfer(points: &[[f32; 3]], scores: &[f32], n_samples: usize, seed: u64) -> Term {
    let mut tape = Tape::default();
    let drawn_from = tape.parameter(Matrix::new(scores.len(), 1, scores.to_vec()));
    let probabilities = inclusion_probabilities(&mut tape, &drawn_from);
    let samples = gumbel_top_k(scores, n_samples, seed);
    let of_samples: Vec<f32> = samples.iter().map(|&v| probabilities.matrix().data()[v as usize]).collect();
    let places: Vec<[f32; 3]> = samples.iter().map(|&v| points[v as usize]).collect();
    let term = probabilistic_chamfer(points, &places, &of_samples);
    let mut gradient = vec![0.0f32; scores.len()];
    samples.iter().zip(&term.gradient).for_each(|(&v, g)| gradient[v as usize] = *g);
    let gradients = tape.backward(&[(&probabilities, Matrix::new(scores.len(), 1, gradient))]);
    let to_scores = gradients.get(&drawn_from).map_or(vec![0.0; scores.len()], |matrix| matrix.data().to_vec());
    Term { value: term.value, gradient: to_scores }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn the_print_has_the_gradient_of_its_value() {
        let points = shapes::icosphere(1).positions().to_vec();
        let scores: Vec<f32> = (0..points.len()).map(|v| (v % 5) as f32 * 0.1).collect();
        // A change of the score this small does not change the drawn sample.
        let moved = |at: usize, by: f32| {
            let mut scores = scores.clone();
            scores[at] += by;
            printed_chamfer(&points, &scores, 12, 3).value
        };
        for (at, gradient) in printed_chamfer(&points, &scores, 12, 3).gradient.into_iter().enumerate() {
            let difference = (moved(at, 2e-3) - moved(at, -2e-3)) / 4e-3;
            assert!((difference - f64::from(gradient)).abs() < 1e-3, "{at}: {difference} {gradient}");
        }
    }
}
