//! Inclusion probabilities of Gumbel-top-k sampling (Sec. 3.1), which make the sampler trainable.

use crate::parallel;

/// Inclusion probability of each vertex, with the data for its gradient.
#[derive(Clone, Debug, PartialEq)]
pub struct Inclusion {
    /// n probabilities in 0..=1 that sum to the number of samples.
    pub probabilities: Vec<f32>,
    /// Derivative of each probability by its score at fixed time t, n.
    slopes: Vec<f64>,
}

/// Computes each vertex's probability to be among the first `n_samples` of Gumbel-top-k.
///
/// Vertex i arrives after an exponential time of rate `exp(s_i)`: by time t with probability `pi_i = 1 - exp(-t exp(s_i))`;
/// t solves `sum_i pi_i = n_samples`.
///
/// # Shapes
/// - `scores`: n, finite
/// - returns n probabilities; all 1 if `n_samples` >= n
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::loss::inclusion;
/// assert_eq!(inclusion(&[3.0; 4], 1).probabilities, [0.25; 4]);
/// assert_eq!(inclusion(&[0.0, 200.0, -50.0, 200.0], 2).probabilities, [0.0, 1.0, 0.0, 1.0]);
/// assert_eq!(inclusion(&[0.0, 1.0], 2).probabilities, [1.0; 2]);
/// ```
pub fn inclusion(scores: &[f32], n_samples: usize) -> Inclusion {
    if n_samples == 0 || n_samples >= scores.len() {
        let p = if n_samples == 0 { 0.0 } else { 1.0 };
        return Inclusion { probabilities: vec![p; scores.len()], slopes: vec![0.0; scores.len()] };
    }
    let log_rates = relative_log_rates(scores, n_samples);
    let log_time = solve_log_time(&log_rates, n_samples as f64);
    let chances = parallel::map(log_rates.len(), BLOCK, |i| arrival_probability(log_rates[i] + log_time));
    let (probabilities, slopes) = chances.into_iter().unzip();
    Inclusion { probabilities: to_f32(probabilities), slopes }
}

/// Returns scores relative to the `n_samples`-th largest, so that t is near 1.
fn relative_log_rates(scores: &[f32], n_samples: usize) -> Vec<f64> {
    let mut order = scores.to_vec();
    let (_, &mut last, _) = order.select_nth_unstable_by(n_samples - 1, |a, b| b.total_cmp(a));
    scores.iter().map(|&s| f64::from(s) - f64::from(last)).collect()
}

/// Converts the gradient to the probabilities into the gradient to the scores.
///
/// With `w_i = t exp(s_i) exp(-t exp(s_i))`: `dL/ds_i = w_i (g_i - sum_j w_j g_j / sum_j w_j)`.
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::loss::{inclusion, inclusion_gradient};
/// let even = inclusion(&[0.0; 2], 1);
/// let gradient = inclusion_gradient(&even, &[1.0, 0.0]);
/// assert!((gradient[0] - 0.5 * 2f32.ln() / 2.0).abs() < 1e-6 && gradient[1] == -gradient[0]);
/// ```
pub fn inclusion_gradient(inclusion: &Inclusion, gradient: &[f32]) -> Vec<f32> {
    let total: f64 = inclusion.slopes.iter().sum();
    let weighted = inclusion.slopes.iter().zip(gradient).map(|(w, &g)| w * f64::from(g));
    let mean = if total > 0.0 { weighted.sum::<f64>() / total } else { 0.0 };
    inclusion.slopes.iter().zip(gradient).map(|(w, &g)| (w * (f64::from(g) - mean)) as f32).collect()
}

/// Returns `1 - exp(-exp(x))` and its derivative to x.
fn arrival_probability(x: f64) -> (f64, f64) {
    // The derivative is zero above this limit; the product below would be infinity times zero.
    let rate = x.min(6.5).exp();
    (-(-rate).exp_m1(), rate * (-rate).exp())
}

/// Scores per parallel task; a fixed number keeps sums independent of the number of threads.
const BLOCK: usize = 4096;

/// Solves `sum_i pi_i = wanted` for the logarithm of t by Newton's method; bisects where a step leaves the bracket.
fn solve_log_time(log_rates: &[f64], wanted: f64) -> f64 {
    // Lower limit: the `wanted - 1` fastest arrivals have probability at most 1 each, all n others at most 1 / n. Upper
    // limit: the `wanted` fastest have rate 1 or more, so each misses probability 1 by at most `exp(-33)`.
    let (mut low, mut high) = (-(log_rates.len() as f64).ln(), 3.5);
    let mut log_time = 0.0;
    for _ in 0..STEPS {
        let (expected, slope) = expected_arrivals(log_rates, log_time);
        let excess = expected - wanted;
        if excess.abs() <= 1e-12 * wanted {
            break;
        }
        *(if excess > 0.0 { &mut high } else { &mut low }) = log_time;
        let newton = log_time - excess / slope;
        log_time = if newton > low && newton < high { newton } else { low.midpoint(high) };
    }
    log_time
}

/// Largest number of iterations, enough for bisection alone.
const STEPS: usize = 64;

/// Returns the expected number of arrivals by a time, and its derivative to the time's logarithm.
fn expected_arrivals(log_rates: &[f64], log_time: f64) -> (f64, f64) {
    let sum_block = |_, block: &[f64]| {
        let each = block.iter().map(|rate| arrival_probability(rate + log_time));
        each.fold((0.0, 0.0), |sum, (p, slope)| (sum.0 + p, sum.1 + slope))
    };
    let blocks = parallel::chunks(log_rates, BLOCK, sum_block);
    blocks.into_iter().fold((0.0, 0.0), |sum, block| (sum.0 + block.0, sum.1 + block.1))
}

fn to_f32(numbers: Vec<f64>) -> Vec<f32> {
    numbers.into_iter().map(|x| x as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::super::Term;
    use super::super::test_gradients::{assert_gradient, uniform};
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn any_scores_give_probabilities_that_sum_to_the_samples(
            scores in prop::collection::vec(prop_oneof![-3.0f32..3.0, -1e4f32..1e4, Just(0.0), Just(1e30)], 1..200),
            share in 0.0f64..1.0,
        ) {
            let n_samples = (share * scores.len() as f64) as usize;
            let found = inclusion(&scores, n_samples);
            prop_assert!(found.probabilities.iter().all(|p| (0.0..=1.0).contains(p)));
            let sum: f64 = found.probabilities.iter().map(|&p| f64::from(p)).sum();
            prop_assert!((sum - n_samples as f64).abs() < 1e-4 * scores.len() as f64, "{sum} of {n_samples}");
            let gradient = inclusion_gradient(&found, &scores.iter().map(|s| s.signum()).collect::<Vec<_>>());
            prop_assert!(gradient.iter().all(|g| g.is_finite()));
        }
    }

    #[test]
    fn gradient_agrees_with_differences() {
        let scores: Vec<f32> = uniform(30, 1).iter().map(|x| 4.0 * x - 2.0).collect();
        let weights = uniform(30, 2);
        assert_gradient(&scores, 2e-3, |scores| {
            let found = inclusion(scores, 10);
            let value = found.probabilities.iter().zip(&weights).map(|(&p, &w)| f64::from(p) * f64::from(w)).sum();
            Term { value, gradient: inclusion_gradient(&found, &weights) }
        });
    }

    #[test]
    fn agrees_with_draws() {
        let scores: Vec<f32> = (0..60).map(|i| (i % 6) as f32 * 0.6).collect();
        let n_draws = 4000;
        let mut counts = vec![0.0; scores.len()];
        for seed in 0..n_draws {
            let noise = uniform(scores.len(), seed + 100);
            let key = |i: usize| scores[i] - (-(noise[i] + 1e-9).ln()).ln();
            let mut order: Vec<usize> = (0..scores.len()).collect();
            order.sort_by(|&a, &b| key(b).total_cmp(&key(a)));
            order[..20].iter().for_each(|&i| counts[i] += 1.0 / n_draws as f32);
        }
        let found = inclusion(&scores, 20).probabilities;
        for (p, count) in found.iter().zip(counts) {
            assert!((p - count).abs() < 0.04, "{p} {count}");
        }
    }

    #[test]
    fn nothing_to_draw_from_and_nothing_to_draw() {
        assert!(inclusion(&[], 3).probabilities.is_empty());
        assert_eq!(inclusion(&[1.0, 2.0], 0).probabilities, [0.0; 2]);
        assert_eq!(inclusion_gradient(&inclusion(&[1.0, 2.0], 0), &[1.0, -1.0]), [0.0; 2]);
    }
}
