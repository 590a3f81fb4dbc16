//! Gumbel-top-k with equal scores: a uniform random subset, the plainest sampling there is.

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

/// Keeps `n_kept` of `0..n`, in order.
pub fn uniform_top_k(n: usize, n_kept: usize, seed: u64) -> Vec<u32> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    // With equal scores the order of the Gumbel noise is that of the uniform numbers under it.
    let mut keys: Vec<(u64, u32)> = (0..n as u32).map(|i| (rng.next_u64(), i)).collect();
    keys.sort_unstable();
    keys.truncate(n_kept);
    let mut kept: Vec<u32> = keys.into_iter().map(|(_, i)| i).collect();
    kept.sort_unstable();
    kept
}
