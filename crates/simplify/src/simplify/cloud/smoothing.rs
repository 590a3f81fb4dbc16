//! Projection of noisy points to the surface through their neighbours (moving least squares; Levin 1998, Alexa et al.
//! 2003).

use super::planes::{fit_plane, point, tangents};
use crate::spatial::{nearest_neighbours, nearest_to};
use glam::DVec3;
use rayon::prelude::*;

/// Thickness of the layer of [`FEWEST`] neighbours from which on a cloud is noisy.
// Clouds of the validation meshes: at most 0.385 without noise, at least 0.457 with noise of 0.5 % of the diagonal.
const NOISY: f64 = 0.42;

/// Neighbours over which noise is looked for.
const FEWEST: usize = 12;

/// Numbers of neighbours, of which the first is taken whose layer is nearly as thin as the thinnest.
const NEIGHBOURS: [usize; 5] = [24, 48, 96, 192, 384];

/// Largest thickness of a layer over that of the thinnest.
// The thinnest itself has four times the neighbours that are best for a statue of the validation meshes, and makes its
// points' error 0.353 % of the diagonal instead of 0.214 %; for smooth shapes, half the best number is taken.
const NEARLY: f64 = 1.1;

/// Points whose neighbours are looked at.
const PROBES: usize = 1000;

/// Rounds in which points move along new normals.
const ROUNDS: usize = 2;

/// Weight of a neighbour: exp(-SHARPNESS d^2 / r^2), where r is the distance of the farthest one.
const SHARPNESS: f64 = 4.0;

/// Ridge on the curvatures, over the sum of the weights.
const RIDGE: f64 = 1e-4;

/// Finds the number of neighbours that smooth the noise of a cloud (n x 3); `None` if it has hardly any.
///
/// Neighbours on a surface are a thin layer. Noise makes layers of few neighbours as thick as wide, and the bends of the
/// surface those of many: the layer is thinnest where the noise is averaged and the shape kept.
pub fn noise_neighbours(points: &[[f32; 3]]) -> Option<usize> {
    if points.len() < FEWEST || thickness(points, FEWEST) < NOISY {
        return None;
    }
    let layers = NEIGHBOURS.map(|k| (k, thickness(points, k)));
    let thinnest = layers.iter().map(|(_, thickness)| *thickness).fold(f64::INFINITY, f64::min);
    layers.into_iter().find(|(_, thickness)| *thickness <= NEARLY * thinnest).map(|(k, _)| k)
}

/// Returns the median thickness, over the width, of the layers of `k` neighbours.
fn thickness(points: &[[f32; 3]], k: usize) -> f64 {
    let step = points.len().div_ceil(PROBES);
    let probes: Vec<[f32; 3]> = points.iter().copied().step_by(step).collect();
    let nearest = nearest_to(points, &probes, k);
    let ratio = |some: &[u32]| {
        let plane = fit_plane(some.iter().map(|&v| (point(points, v), 1.0)));
        plane.spread[0] / plane.spread[1].max(f64::MIN_POSITIVE)
    };
    let mut ratios: Vec<f64> = nearest.par_chunks_exact(k.min(points.len())).map(ratio).collect();
    let middle = ratios.len() / 2;
    *ratios.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Moves every point to the quadratic surface that fits its `k` nearest points.
///
/// # Shapes
/// - `points` and the result: n x 3
pub fn smooth_points(points: &[[f32; 3]], k: usize) -> Vec<[f32; 3]> {
    let k = k.min(points.len() - 1);
    let nearest = nearest_neighbours(points, k);
    let smooth = |(v, some): (usize, &[u32])| {
        let around: Vec<DVec3> = some.iter().chain([&(v as u32)]).map(|&w| point(points, w)).collect();
        let mut p = point(points, v as u32);
        (0..ROUNDS).for_each(|_| p = project_to_surface(p, &around));
        p.as_vec3().to_array()
    };
    nearest.par_chunks_exact(k).enumerate().map(smooth).collect()
}

fn project_to_surface(p: DVec3, around: &[DVec3]) -> DVec3 {
    let reach = around.iter().map(|q| q.distance_squared(p)).fold(0.0, f64::max);
    if reach == 0.0 {
        return p;
    }
    let weighted: Vec<(DVec3, f64)> =
        around.iter().map(|&q| (q, (-SHARPNESS * q.distance_squared(p) / reach).exp())).collect();
    let plane = fit_plane(weighted.iter().copied());
    if plane.normal == DVec3::ZERO {
        return p;
    }
    let foot = p - (p - plane.centre).dot(plane.normal) * plane.normal;
    let ([x, y], unit) = (tangents(plane.normal), reach.sqrt());
    let samples = weighted.into_iter().map(|(q, weight)| {
        let d = (q - foot) / unit;
        ([d.dot(x), d.dot(y)], d.dot(plane.normal), weight)
    });
    foot + fit_height(samples).unwrap_or(0.0) * unit * plane.normal
}

/// Fits a quadratic to heights over points of the plane, with weights; returns its height at the origin.
fn fit_height(samples: impl Iterator<Item = ([f64; 2], f64, f64)>) -> Option<f64> {
    let (mut matrix, mut right, mut total) = ([[0.0; 6]; 6], [0.0; 6], 0.0);
    for ([x, y], z, weight) in samples {
        let terms = [x * x, x * y, y * y, x, y, 1.0];
        total += weight;
        for (i, term) in terms.iter().enumerate() {
            right[i] += weight * term * z;
            (0..=i).for_each(|j| matrix[i][j] += weight * term * terms[j]);
        }
    }
    (0..3).for_each(|i| matrix[i][i] += RIDGE * total);
    solve_last(matrix, right)
}

/// Returns the last unknown of a positive definite system, of which the lower triangle is read (Cholesky).
fn solve_last(mut m: [[f64; 6]; 6], mut x: [f64; 6]) -> Option<f64> {
    for i in 0..6 {
        for j in 0..i {
            m[i][j] = (m[i][j] - (0..j).map(|k| m[i][k] * m[j][k]).sum::<f64>()) / m[j][j];
        }
        let pivot = m[i][i] - (0..i).map(|k| m[i][k] * m[i][k]).sum::<f64>();
        if pivot <= 1e-12 * m[i][i] {
            return None;
        }
        m[i][i] = pivot.sqrt();
        x[i] = (x[i] - (0..i).map(|k| m[i][k] * x[k]).sum::<f64>()) / m[i][i];
    }
    Some(x[5] / m[5][5])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rand_xoshiro::rand_core::{Rng, SeedableRng};

    fn noisy_sphere(noise: f64) -> Vec<[f32; 3]> {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
        let mut uniform = || (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
        // The sum of twelve uniform numbers is nearly normal, of variance 1.
        let mut normal = || (0..12).map(|_| uniform()).sum::<f64>();
        let move_point = |p: &[f32; 3]| p.map(|x| x + (noise * normal()) as f32);
        shapes::icosphere(5).positions().iter().map(move_point).collect()
    }

    fn error(points: &[[f32; 3]]) -> f64 {
        let squares = points.iter().map(|&p| (DVec3::from(p.map(f64::from)).length() - 1.0).powi(2));
        (squares.sum::<f64>() / points.len() as f64).sqrt()
    }

    #[test]
    fn noise_is_found_and_smoothed() {
        assert_eq!(noise_neighbours(&noisy_sphere(0.0)), None);
        let noisy = noisy_sphere(0.03);
        let k = noise_neighbours(&noisy).unwrap();
        let [before, after] = [error(&noisy), error(&smooth_points(&noisy, k))];
        assert!(after < 0.25 * before, "{k}: {before} {after}");
    }

    #[test]
    fn points_on_a_quadric_stay() {
        let points: Vec<[f32; 3]> = (0..400)
            .map(|i| [(i % 20) as f32 / 20.0, (i / 20) as f32 / 20.0])
            .map(|[x, y]| [x, y, 0.1 * x * x + 0.2 * x * y])
            .collect();
        let moved = |(p, q): (&[f32; 3], &[f32; 3])| p.iter().zip(q).all(|(a, b)| (a - b).abs() < 2e-4);
        assert!(points.iter().zip(&smooth_points(&points, 24)).all(moved));
    }

    #[test]
    fn the_last_unknown_is_that_of_the_whole_system() {
        let mut matrix = [[0.0; 6]; 6];
        (0..6).for_each(|i| (0..6).for_each(|j| matrix[i][j] = if i == j { 7.0 } else { 1.0 / (1 + i + j) as f64 }));
        let x = [1.0, -2.0, 3.0, 0.5, 0.0, 4.0];
        let right = std::array::from_fn(|i| (0..6).map(|j| matrix[i][j] * x[j]).sum());
        assert!((solve_last(matrix, right).unwrap() - 4.0).abs() < 1e-9);
        assert_eq!(solve_last([[0.0; 6]; 6], [1.0; 6]), None);
    }
}
