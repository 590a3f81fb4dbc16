//! Curvature error of drawn samples, Sec. 4.4, with a gradient through the draw.
//!
//! The printed loss compares curvatures of the original alone; the error of Table 2 also depends on the curvature that the samples have
//! among themselves, which is no function of probabilities. So the gradient is that of the score function (Williams 1992).

use super::Term;
use crate::spatial::{nearest_to, point_curvature};

/// Samples whose curvature a sample changes: the neighbours of [`point_curvature`].
const REACH: usize = 10;

/// Measures the curvature error of two independent draws, and estimates its gradient by the scores.
///
/// The value is the logarithm of the mean over the draws of `mean_x (k_x - k_y)^2 + mean_y (k_y - k_x)^2`: x over the originals, y over
/// the samples, each with the nearest of the others, k by [`point_curvature`] within its own set. A vertex that one draw has and the
/// other has not is credited with half of the difference of the errors near it, so that what both share cancels. By the logarithm,
/// small and large samples weigh alike; it is 0 if nothing differs.
///
/// # Shapes
/// - `points`: n x 3; `originals`: n x 3, the points without noise
/// - `draws`: vertices drawn from the scores with two seeds
/// - returns a gradient of n
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::loss::curvature_of_draws;
/// let wave: Vec<[f32; 3]> = (0..400).map(|i| [(i % 20) as f32, (i / 20) as f32, (i as f32).sin()]).collect();
/// let [even, all]: [Vec<u32>; 2] = [(0..400).step_by(2).collect(), (0..400).collect()];
/// let [some, none] = [&even, &all].map(|draw| curvature_of_draws(&wave, &wave, [draw, draw]).value);
/// assert!(some < 0.0 && none == 0.0);
/// ```
pub fn curvature_of_draws(points: &[[f32; 3]], originals: &[[f32; 3]], draws: [&[u32]; 2]) -> Term {
    if draws.iter().any(|draw| draw.is_empty()) {
        return Term::zero(points.len());
    }
    let curvature = point_curvature(originals);
    let [first, second] = draws.map(|draw| measure_draw(points, originals, &curvature, draw));
    let mean = 0.5 * (first.error + second.error);
    if mean <= 0.0 {
        return Term::zero(points.len());
    }
    let mut gradient = vec![0.0f32; points.len()];
    for (draw, share) in [(draws[0], 0.5 / mean), (draws[1], -0.5 / mean)] {
        for &v in draw {
            let v = v as usize;
            gradient[v] += (share * (first.near_points[v] - second.near_points[v])) as f32;
        }
    }
    Term { value: mean.ln(), gradient }
}

struct MeasuredDraw {
    error: f64,
    /// Part of the error at the samples nearest to each point, n.
    near_points: Vec<f64>,
}

fn measure_draw(points: &[[f32; 3]], originals: &[[f32; 3]], curvature: &[f32], draw: &[u32]) -> MeasuredDraw {
    let sampled: Vec<[f32; 3]> = draw.iter().map(|&v| points[v as usize]).collect();
    let of_samples = point_curvature(&sampled);
    let squared = |x: usize, y: usize| f64::from(curvature[x] - of_samples[y]).powi(2);
    let partners = nearest_to(originals, &sampled, 1);
    let own = partners.iter().enumerate().map(|(y, &x)| squared(x as usize, y) / draw.len() as f64);
    let mut errors: Vec<f64> = own.collect();
    for (x, y) in nearest_to(&sampled, originals, 1).into_iter().enumerate() {
        errors[y as usize] += squared(x, y as usize) / originals.len() as f64;
    }
    let near = nearest_to(&sampled, points, REACH);
    let rows = near.chunks_exact(near.len() / points.len());
    let near_points = rows.map(|row| row.iter().map(|&y| errors[y as usize]).sum()).collect();
    MeasuredDraw { error: errors.iter().sum(), near_points }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of a plane, of which one half is rough.
    fn half_rough(n: usize) -> Vec<[f32; 3]> {
        let height = |i: usize, j: usize| if i < n / 2 { ((i * 7 + j * 13) % 5) as f32 * 0.3 } else { 0.0 };
        (0..n * n).map(|at| [(at % n) as f32, (at / n) as f32, height(at % n, at / n)]).collect()
    }

    #[test]
    fn the_error_is_that_of_its_definition() {
        let points = half_rough(12);
        let draw: Vec<u32> = (0..144).filter(|v| v % 3 != 1).collect();
        let sampled: Vec<[f32; 3]> = draw.iter().map(|&v| points[v as usize]).collect();
        let [k, l] = [&points, &sampled].map(|points| point_curvature(points));
        let mean = |from: &[f32], to: &[f32], near: Vec<u32>| {
            let squares = from.iter().zip(near).map(|(a, at)| f64::from(a - to[at as usize]).powi(2));
            squares.sum::<f64>() / from.len() as f64
        };
        let expected = mean(&k, &l, nearest_to(&sampled, &points, 1)) + mean(&l, &k, nearest_to(&points, &sampled, 1));
        let term = curvature_of_draws(&points, &points, [&draw, &draw]);
        assert!((term.value - expected.ln()).abs() < 1e-9);
        assert_eq!(term.gradient, vec![0.0; 144]);
    }

    #[test]
    fn the_gradient_asks_for_samples_where_they_lower_the_error() {
        // One draw has the rough half, the other the flat half: each lacks what the other has.
        let points = half_rough(16);
        let some = |v: u32, rough: u32, flat: u32| v % (if (v % 16) < 8 { rough } else { flat }) == 0;
        let [mostly_rough, mostly_flat]: [Vec<u32>; 2] =
            [(1, 5), (5, 1)].map(|(rough, flat)| (0..256).filter(|&v| some(v, rough, flat)).collect());
        let gradient = curvature_of_draws(&points, &points, [&mostly_rough, &mostly_flat]).gradient;
        let sum = |rough: bool| (0..256).filter(|v| (v % 16 < 8) == rough).map(|v| gradient[v]).sum::<f32>();
        assert!(sum(true) < 0.0 && sum(true) < sum(false), "{} {}", sum(true), sum(false));
    }

    #[test]
    fn nothing_and_flat_things_have_no_gradient() {
        assert_eq!(curvature_of_draws(&[[0.0; 3]], &[[0.0; 3]], [&[], &[0]]), Term::zero(1));
        let flat = half_rough(12)[6..12].to_vec();
        assert_eq!(curvature_of_draws(&flat, &flat, [&[0, 1, 2], &[3, 4]]), Term::zero(6));
    }
}
