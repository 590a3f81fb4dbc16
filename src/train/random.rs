//! Random numbers of a training.
//!
//! ```
//! use neural_mesh::train::random::{random_below, shuffle_indices, uniform};
//! use rand_xoshiro::{Xoshiro256PlusPlus, rand_core::SeedableRng};
//! let mut random = Xoshiro256PlusPlus::seed_from_u64(7);
//! assert!((0.0..1.0).contains(&uniform(&mut random)) && random_below(&mut random, 3) < 3);
//! assert_eq!(shuffle_indices(&mut random, 5).len(), 5);
//! ```

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::Rng;

/// Draws a uniform number in 0..1 with 53 bits.
pub fn uniform(random: &mut Xoshiro256PlusPlus) -> f64 {
    (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

/// Draws one of the numbers 0 to n - 1; n is above 0.
pub fn random_below(random: &mut Xoshiro256PlusPlus, n: usize) -> usize {
    ((uniform(random) * n as f64) as usize).min(n - 1)
}

pub(super) fn log_uniform(random: &mut Xoshiro256PlusPlus, low: f64, high: f64) -> f64 {
    (low.ln() + uniform(random) * (high.ln() - low.ln())).exp().clamp(low, high)
}

/// Draws two independent standard normal numbers (Box and Muller 1958).
pub(super) fn normal_pair(random: &mut Xoshiro256PlusPlus) -> [f64; 2] {
    let radius = (-2.0 * (1.0 - uniform(random)).ln()).sqrt();
    let (sin, cos) = (std::f64::consts::TAU * uniform(random)).sin_cos();
    [radius * cos, radius * sin]
}

/// Returns the numbers 0 to n - 1 in random order (Fisher and Yates).
pub fn shuffle_indices(random: &mut Xoshiro256PlusPlus, n: usize) -> Vec<u32> {
    let mut order: Vec<u32> = (0..n as u32).collect();
    for last in (1..n).rev() {
        order.swap(last, random_below(random, last + 1));
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_xoshiro::rand_core::SeedableRng;

    #[test]
    fn numbers_have_their_moments() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
        let normals: Vec<f64> = (0..20_000).flat_map(|_| normal_pair(&mut random)).collect();
        let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / normals.len() as f64;
        assert!(mean(&mut normals.iter().copied()).abs() < 0.02);
        assert!((mean(&mut normals.iter().map(|x| x * x)) - 1.0).abs() < 0.03);
        let low = (0..10_000).filter(|_| log_uniform(&mut random, 0.01, 1.0) < 0.1).count();
        assert!((4800..5200).contains(&low), "{low}");
    }

    #[test]
    fn shuffling_loses_nothing_and_favours_nobody() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(2);
        let mut first = [0; 5];
        for _ in 0..5000 {
            let mut order = shuffle_indices(&mut random, 5);
            first[order[0] as usize] += 1;
            order.sort_unstable();
            assert_eq!(order, [0, 1, 2, 3, 4]);
        }
        assert!(first.iter().all(|n| (850..1150).contains(n)), "{first:?}");
        assert!(shuffle_indices(&mut random, 0).is_empty());
    }
}
