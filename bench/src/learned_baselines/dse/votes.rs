//! Votes of patches for triangles.

use super::{Patch, umbrella};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// Returns each triangle with its votes: the corners whose umbrella contains it, 1 to 3; sorted by
/// corners.
pub fn count_votes(patches: &[Patch]) -> Vec<([u32; 3], u8)> {
    let umbrellas: Vec<Vec<[u32; 3]>> = patches.par_iter().map(umbrella).collect();
    let mut counts: FxHashMap<[u32; 3], u8> = FxHashMap::default();
    umbrellas.into_iter().flatten().for_each(|corners| *counts.entry(corners).or_default() += 1);
    let mut counted: Vec<([u32; 3], u8)> = counts.into_iter().collect();
    counted.sort_unstable();
    counted
}

#[cfg(test)]
mod tests {
    use super::super::exact_patches;
    use super::*;
    use neural_mesh::mesh::shapes;

    #[test]
    fn on_a_round_surface_all_agree() {
        let sphere = shapes::icosphere(3);
        let samples: Vec<u32> = (0..sphere.positions().len() as u32).collect();
        let counted = count_votes(&exact_patches(&sphere, &samples, 24));
        let unanimous = counted.iter().filter(|(_, votes)| *votes == 3).count();
        assert_eq!((unanimous, counted.len()), (1280, 1280));
    }
}
