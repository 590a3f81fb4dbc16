//! Alignment of neighbouring logarithmic maps.

use super::{Patch, Turn};
use neural_mesh::parallel;
use rustc_hash::FxHashMap;

// Fewest points that two patches must share to be aligned: a third of a patch, as in the paper's program.
const LEAST_COMMON: usize = 8;
// Smallest weight of a point in an alignment, from the paper's program.
const LEAST_WEIGHT: f64 = 0.2;
// Points farther from the median than this fraction of the patch's radius are left out.
const OUTLIER: f64 = 0.25;

type WeightedPoint = ([f64; 2], f64);

/// Replaces each map by the mean of itself and the aligned maps of its points.
///
/// # Shapes
/// - `patches`: one per point of the cloud, in order
pub fn align_maps(patches: &[Patch]) -> Vec<Patch> {
    let aligned = |patch: &Patch| Patch { points: patch.points.clone(), map: mean_map(patch, patches) };
    parallel::map(patches.len(), 16, |i| aligned(&patches[i]))
}

fn mean_map(patch: &Patch, patches: &[Patch]) -> Vec<[f64; 2]> {
    let slots: FxHashMap<u32, usize> = patch.points.iter().zip(0..).map(|(&point, slot)| (point, slot)).collect();
    let own = weights(patch);
    let mut places: Vec<Vec<WeightedPoint>> =
        patch.map.iter().zip(&own).map(|(&at, &weight)| vec![(at, weight)]).collect();
    for &neighbour in patch.points.iter().skip(1) {
        let other = &patches[neighbour as usize];
        let common: Vec<[usize; 2]> =
            other.points.iter().zip(0..).filter_map(|(point, theirs)| Some([*slots.get(point)?, theirs])).collect();
        if common.len() < LEAST_COMMON {
            continue;
        }
        let theirs = weights(other);
        for ([slot, there], at) in common.iter().zip(align_points(patch, other, &common)) {
            places[*slot].push((at, own[*slot] * theirs[*there]));
        }
    }
    let radius = patch.radius();
    places.iter().map(|places| mean_without_outliers(places, OUTLIER * radius)).collect()
}

fn weights(patch: &Patch) -> Vec<f64> {
    let unit = (2.0 * patch.radius()).max(1e-30);
    patch.map.iter().map(|at| (1.0 - at[0].hypot(at[1]) / unit).powi(2).max(LEAST_WEIGHT)).collect()
}

fn align_points(patch: &Patch, other: &Patch, common: &[[usize; 2]]) -> Vec<[f64; 2]> {
    let pairs: Vec<[[f64; 2]; 2]> = common.iter().map(|&[here, there]| [patch.map[here], other.map[there]]).collect();
    let mean = |of: usize| [0, 1].map(|axis| pairs.iter().map(|pair| pair[of][axis]).sum::<f64>() / pairs.len() as f64);
    let (here, there) = (mean(0), mean(1));
    let minus = |a: [f64; 2], b: [f64; 2]| [a[0] - b[0], a[1] - b[1]];
    let turn = Turn::fit(pairs.iter().map(|pair| (minus(pair[1], there), minus(pair[0], here), 1.0)));
    let moved = pairs.iter().map(|pair| turn.apply(minus(pair[1], there)));
    moved.map(|at| [at[0] + here[0], at[1] + here[1]]).collect()
}

fn mean_without_outliers(places: &[WeightedPoint], most: f64) -> [f64; 2] {
    let median = [0, 1].map(|axis| weighted_median(places, axis));
    let is_near = |&&(at, _): &&WeightedPoint| (at[0] - median[0]).hypot(at[1] - median[1]) <= most;
    let near: Vec<WeightedPoint> = places.iter().filter(is_near).copied().collect();
    let counted = if near.is_empty() { places } else { &near };
    let total: f64 = counted.iter().map(|(_, weight)| weight).sum();
    [0, 1].map(|axis| counted.iter().map(|(at, weight)| at[axis] * weight).sum::<f64>() / total)
}

fn weighted_median(places: &[WeightedPoint], axis: usize) -> f64 {
    let mut sorted: Vec<(f64, f64)> = places.iter().map(|(at, weight)| (at[axis], *weight)).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * sorted.iter().map(|(_, weight)| weight).sum::<f64>();
    let mut below = 0.0;
    let middle = sorted.iter().find(|(_, weight)| {
        below += weight;
        below >= half
    });
    middle.map_or(0.0, |(x, _)| *x)
}

#[cfg(test)]
mod tests {
    use super::super::exact_patches;
    use super::*;
    use neural_mesh::mesh::shapes;

    fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
        (a[0] - b[0]).hypot(a[1] - b[1])
    }

    #[test]
    fn maps_that_agree_stay_and_a_wrong_place_is_corrected() {
        let grid = shapes::grid(8, 8);
        let patches = exact_patches(&grid, &(0..81).collect::<Vec<u32>>(), 24);
        let largest = |found: &[Patch]| {
            let pairs = found.iter().zip(&patches).flat_map(|(a, b)| a.map.iter().zip(&b.map));
            pairs.map(|(a, b)| distance(*a, *b)).fold(0.0, f64::max)
        };
        // Corners occur in few other patches, with similar maps.
        assert!(largest(&align_maps(&patches)) < 1e-6);
        let mut wrong = patches.clone();
        wrong[40].map[5][0] += 0.1;
        let (before, after) = (distance(wrong[40].map[5], patches[40].map[5]), align_maps(&wrong));
        assert!(distance(after[40].map[5], patches[40].map[5]) < 0.1 * before);
    }

    #[test]
    fn outliers_do_not_count() {
        let places = [([1.0, 2.0], 1.0), ([1.2, 2.0], 3.0), ([9.0, 9.0], 1.0)];
        let [x, y] = mean_without_outliers(&places, 0.5);
        assert!((x - 1.15).abs() < 1e-12 && (y - 2.0).abs() < 1e-12);
        assert_eq!(mean_without_outliers(&places[2..], 0.0), [9.0, 9.0]);
    }
}
