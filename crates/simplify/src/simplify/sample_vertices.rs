//! Vertex sampling by scores without replacement (Sec. 3.1).

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

/// Draws k different vertices, one by one, with probabilities proportional to `exp(score)` among the remaining ones.
///
/// The k largest sums of score and Gumbel noise win (Kool et al. 2019).
///
/// # Shapes
/// - `scores`: n
/// - returns min(k, n) vertices, ascending
///
/// ```
/// # use neural_mesh_simplify as neural_mesh;
/// use neural_mesh::simplify::gumbel_top_k;
/// let samples = gumbel_top_k(&[0.0; 100], 10, 7);
/// assert_eq!(samples.len(), 10);
/// assert_eq!(gumbel_top_k(&[0.0, 1e9, 0.0, 1e9], 2, 7), [1, 3]);
/// ```
pub fn gumbel_top_k(scores: &[f32], k: usize, seed: u64) -> Vec<u32> {
    let mut keys = gumbel_keys(scores, seed);
    let k = k.min(keys.len());
    // Selection takes linear time, sorting would not; ties go by vertex.
    if k < keys.len() {
        keys.select_nth_unstable_by(k, |a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    }
    let mut samples: Vec<u32> = keys[..k].iter().map(|&(_, vertex)| vertex).collect();
    samples.sort_unstable();
    samples
}

pub(super) fn gumbel_keys(scores: &[f32], seed: u64) -> Vec<(f64, u32)> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    scores.iter().zip(0..).map(|(&score, vertex)| (f64::from(score) + gumbel(rng.next_u64()), vertex)).collect()
}

fn gumbel(bits: u64) -> f64 {
    let uniform = ((bits >> 12) as f64 + 0.5) / (1u64 << 52) as f64;
    -(-uniform.ln()).ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_draws_follow_the_softmax() {
        let scores = [0.0, 1.0, 2.0];
        let n_draws = 20_000;
        let mut counts = [0; 3];
        (0..n_draws).for_each(|seed| counts[gumbel_top_k(&scores, 1, seed)[0] as usize] += 1);
        let sum: f32 = scores.iter().map(|s| s.exp()).sum();
        for (score, count) in scores.iter().zip(counts) {
            assert!((score.exp() / sum - count as f32 / n_draws as f32).abs() < 0.015);
        }
    }

    #[test]
    fn pairs_follow_draws_without_replacement() {
        let p = [0.5f64, 0.3, 0.2];
        let scores = p.map(|p| p.ln() as f32);
        let n_draws = 20_000;
        let count = (0..n_draws).filter(|&seed| gumbel_top_k(&scores, 2, seed) == [0, 1]).count();
        let expected = p[0] * p[1] / (1.0 - p[0]) + p[1] * p[0] / (1.0 - p[1]);
        assert!((expected - count as f64 / n_draws as f64).abs() < 0.015);
    }

    #[test]
    fn sizes_are_exact_and_extremes_of_the_noise_finite() {
        for k in [0, 1, 50, 99, 100, 200] {
            let samples = gumbel_top_k(&[0.5; 100], k, 3);
            assert_eq!(samples.len(), k.min(100));
            assert!(samples.is_sorted_by(|a, b| a < b));
        }
        assert!(gumbel(0).is_finite() && gumbel(u64::MAX).is_finite());
        assert_ne!(gumbel_top_k(&[0.5; 100], 50, 3), gumbel_top_k(&[0.5; 100], 50, 4));
    }
}
