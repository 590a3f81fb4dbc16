//! Trained weights in random order.

use std::sync::Arc;

use anyhow::Result;
use neural_mesh::linalg::Matrix;
use neural_mesh::model::Weights;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

/// Permutes the entries of every tensor (Fisher and Yates).
pub fn shuffle_weights(weights: &Weights, seed: u64) -> Result<Weights> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let tensors = weights.tensors().map(|_, tensor| {
        let mut shuffled = Matrix::clone(tensor);
        shuffle_entries(shuffled.data_mut(), &mut rng);
        Arc::new(shuffled)
    });
    Ok(Weights::from_tensors(*weights.architecture(), tensors)?)
}

fn shuffle_entries(entries: &mut [f32], rng: &mut Xoshiro256PlusPlus) {
    for last in (1..entries.len()).rev() {
        let other = (u128::from(rng.next_u64()) * (last as u128 + 1)) >> 64;
        entries.swap(last, other as usize);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_tensor_keeps_its_entries() {
        let weights = Weights::random(1);
        let other = shuffle_weights(&weights, 2).unwrap();
        assert_ne!(other, weights);
        assert_eq!(other, shuffle_weights(&weights, 2).unwrap());
        let sorted = |weights: &Weights| {
            let mut all: Vec<Vec<f32>> = Vec::new();
            weights.tensors().map(|_, tensor| all.push(tensor.data().to_vec()));
            all.iter_mut().for_each(|entries| entries.sort_by(f32::total_cmp));
            all
        };
        assert_eq!(sorted(&other), sorted(&weights));
    }
}
