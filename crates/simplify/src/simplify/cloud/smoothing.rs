//! Projection of noisy points to the surface through their neighbours (moving least squares; Levin 1998, Alexa et al.
//! 2003).

use super::planes::{fit_plane, point, tangents};
use crate::parallel;
use crate::spatial::nearest_to;
use glam::DVec3;
use rayon::prelude::*;

/// Thickness of the layer of [`FEWEST`] neighbours from which on a cloud is noisy.
// Clouds of the validation meshes: at most 0.385 without noise, at least 0.457 with noise of 0.5 % of the diagonal.
const NOISY: f64 = 0.42;

/// Neighbours over which noise is looked for.
const FEWEST: usize = 12;

/// Numbers of neighbours, of which the first is taken whose layer is nearly as thin as the thinnest and reaches far enough.
const NEIGHBOURS: [usize; 5] = [24, 48, 96, 192, 384];

/// Largest thickness of a layer over that of the thinnest.
// The thinnest itself has four times the neighbours that are best for a statue of the validation meshes, and makes its
// points' error 0.353 % of the diagonal instead of 0.214 %; for smooth shapes, half the best number is taken.
const NEARLY: f64 = 1.1;

/// Thickness from which on neighbours are no layer but a ball.
// In balls, the ratio of the least to the middle spread is 0.7 to 0.85, by chance.
const SOLID: f64 = 0.6;

/// Least distance of the farthest neighbour, over the noise.
const REACH: f64 = 3.0;

/// Points whose neighbours are looked at.
const PROBES: usize = 1000;

/// Times that all points are smoothed.
const PASSES: usize = 2;

/// Rounds of a pass, in which points move along new normals.
const ROUNDS: usize = 3;

/// Weight of a neighbour: exp(-SHARPNESS d^2 / r^2), where r is the distance of the farthest one.
const SHARPNESS: f64 = 4.0;

/// Ridge on the curvatures, over the sum of the weights.
const RIDGE: f64 = 1e-4;

/// A cloud whose noise is smoothed.
pub struct SmoothedPoints {
    /// Points in the order of the cloud, n x 3.
    pub points: Vec<[f32; 3]>,
    /// Mean number of points in a cube as wide as the noise, around each point, n.
    pub crowding: Vec<f32>,
    /// Number of cubes over which the first pass smoothed.
    pub neighbours: usize,
}

/// Moves every point to the quadratic surfaces that fit the means of its neighbours; `None` if there is hardly any noise.
///
/// Means of cubes as wide as the noise replace the points, so that neighbourhoods of dense and sparse points are as wide.
///
/// # Shapes
/// - `points`: n x 3
pub fn smooth_noise(points: &[[f32; 3]]) -> Option<SmoothedPoints> {
    let is_noisy =
        points.len() >= FEWEST && median(&NeighbourLayers::new(points, &[FEWEST]).thickness[0], None) >= NOISY;
    is_noisy.then(|| {
        let first = smooth_once(points);
        let points = (1..PASSES).fold(first.points, |points, _| smooth_once(&points).points);
        SmoothedPoints { points, ..first }
    })
}

fn smooth_once(points: &[[f32; 3]]) -> SmoothedPoints {
    let noise = estimate_noise(points);
    let (means, counts) = cell_means(points, noise);
    let neighbours = choose_neighbours(&means, noise).min(means.len());
    let nearest = nearest_to(&means, points, neighbours);
    let smooth = |v: usize| {
        let some = &nearest[v * neighbours..][..neighbours];
        let around: Vec<(DVec3, f64)> = some.iter().map(|&w| (point(&means, w), counts[w as usize])).collect();
        let mut p = point(points, v as u32);
        (0..ROUNDS).for_each(|_| p = project_to_surface(p, &around));
        let crowding = around.iter().map(|(_, count)| count).sum::<f64>() / around.len() as f64;
        (p.as_vec3().to_array(), crowding as f32)
    };
    let (points, crowding) = parallel::map(points.len(), 16, smooth).into_iter().unzip();
    SmoothedPoints { points, crowding, neighbours }
}

/// Layers of the neighbours of some points of a cloud, of several numbers of neighbours.
struct NeighbourLayers {
    /// Least spread over the middle one; for each number, of each probe.
    thickness: Vec<Vec<f64>>,
    /// Least spread.
    height: Vec<Vec<f64>>,
    /// Distance of the farthest neighbour.
    reach: Vec<Vec<f64>>,
}

impl NeighbourLayers {
    fn new(points: &[[f32; 3]], numbers: &[usize]) -> Self {
        let step = points.len().div_ceil(PROBES);
        let probes: Vec<[f32; 3]> = points.iter().copied().step_by(step).collect();
        let most = numbers[numbers.len() - 1].min(points.len());
        let nearest = nearest_to(points, &probes, most);
        // Thickness, height and reach.
        let measure = |probe: usize, some: &[u32]| {
            let [low, middle, _] = fit_plane(some.iter().map(|&v| (point(points, v), 1.0))).spread;
            let farthest = point(points, some[some.len() - 1]);
            [low / middle.max(f64::MIN_POSITIVE), low, farthest.distance(point(&probes, probe as u32))]
        };
        let of_number = |&k: &usize| -> Vec<[f64; 3]> {
            parallel::map(probes.len(), 16, |probe| measure(probe, &nearest[probe * most..][..k.min(most)]))
        };
        let layers: Vec<Vec<[f64; 3]>> = numbers.iter().map(of_number).collect();
        let values = |i: usize| layers.iter().map(|some| some.iter().map(|layer| layer[i]).collect()).collect();
        Self { thickness: values(0), height: values(1), reach: values(2) }
    }
}

/// Returns the standard deviation of the noise: the median over the surface of the heights of layers.
///
/// The layer of a probe is the first that doubling makes thicker. Balls of noise are no layers.
fn estimate_noise(points: &[[f32; 3]]) -> f64 {
    let NeighbourLayers { thickness, height, reach } = NeighbourLayers::new(points, &NEIGHBOURS);
    let height_at = |probe: usize| {
        let layers: Vec<f64> = thickness.iter().map(|of_probes| of_probes[probe]).collect();
        let thickens = |i: &usize| layers.get(i + 1).is_none_or(|next| next >= &layers[*i]);
        let first = (0..layers.len()).find(|i| layers[*i] < SOLID && thickens(i));
        let thinnest = || (0..layers.len()).min_by(|&a, &b| layers[a].total_cmp(&layers[b]));
        height[first.or_else(thinnest).unwrap_or(0)][probe]
    };
    let heights: Vec<f64> = (0..height[0].len()).map(height_at).collect();
    // Probes are as dense as the points, so each is weighted by its area, the square of the reach.
    let areas: Vec<f64> = reach[0].iter().map(|reach| reach * reach).collect();
    median(&heights, Some(&areas))
}

/// Finds the number of neighbours that smooth noise of a standard deviation.
///
/// Neighbours on a surface are a thin layer. Noise makes layers of few neighbours as thick as wide, and the bends of the
/// surface those of many: the layer is thinnest where the noise is averaged and the shape kept.
fn choose_neighbours(points: &[[f32; 3]], noise: f64) -> usize {
    let layers = NeighbourLayers::new(points, &NEIGHBOURS);
    let thick: Vec<f64> = layers.thickness.iter().map(|some| median(some, None)).collect();
    let thinnest = thick.iter().copied().fold(f64::INFINITY, f64::min);
    let is_fit = |i: &usize| thick[*i] <= NEARLY * thinnest;
    let is_far = |i: &usize| median(&layers.reach[*i], None) >= REACH * noise;
    let last = NEIGHBOURS.len() - 1;
    let [fit, far] = [(0..last).find(is_fit), (0..last).find(is_far)].map(|found| found.unwrap_or(last));
    NEIGHBOURS[fit.max(far)]
}

/// Returns the means of the points in each cube of a width, and their numbers.
fn cell_means(points: &[[f32; 3]], width: f64) -> (Vec<[f32; 3]>, Vec<f64>) {
    if width == 0.0 {
        return (points.to_vec(), vec![1.0; points.len()]);
    }
    let low = points.iter().fold([f32::INFINITY; 3], |low, p| [0, 1, 2].map(|axis| low[axis].min(p[axis])));
    let cell = |p: &[f32; 3]| [0, 1, 2].map(|axis| ((f64::from(p[axis]) - f64::from(low[axis])) / width) as u64);
    let mut cells: Vec<([u64; 3], u32)> = points.iter().map(cell).zip(0..).collect();
    cells.par_sort_unstable();
    let mean = |some: &[([u64; 3], u32)]| {
        let sum: DVec3 = some.iter().map(|&(_, v)| point(points, v)).sum();
        ((sum / some.len() as f64).as_vec3().to_array(), some.len() as f64)
    };
    cells.chunk_by(|a, b| a.0 == b.0).map(mean).unzip()
}

/// Returns the value at which half of the weights, 1 by default, is exceeded.
fn median(values: &[f64], weights: Option<&[f64]>) -> f64 {
    let weight = |i: usize| weights.map_or(1.0, |weights| weights[i]);
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let half = 0.5 * order.iter().map(|&i| weight(i)).sum::<f64>();
    let mut sum = 0.0;
    let is_beyond = |i: &&usize| {
        sum += weight(**i);
        sum > half
    };
    order.iter().find(is_beyond).or(order.last()).map_or(0.0, |&i| values[i])
}

/// Moves a point to the surface through points with weights.
fn project_to_surface(p: DVec3, around: &[(DVec3, f64)]) -> DVec3 {
    let reach = around.iter().map(|(q, _)| q.distance_squared(p)).fold(0.0, f64::max);
    if reach == 0.0 {
        return p;
    }
    let fade = |q: DVec3| (-SHARPNESS * q.distance_squared(p) / reach).exp();
    let weighted: Vec<(DVec3, f64)> = around.iter().map(|&(q, weight)| (q, weight * fade(q))).collect();
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
        assert!(smooth_noise(&noisy_sphere(0.0)).is_none());
        // Points are 0.035 apart.
        for noise in [0.03, 0.1] {
            let noisy = noisy_sphere(noise);
            let smooth = smooth_noise(&noisy).unwrap();
            let [before, after] = [error(&noisy), error(&smooth.points)];
            assert!(after < 0.25 * before, "{}: {before} {after}", smooth.neighbours);
        }
    }

    #[test]
    fn half_of_the_weights_is_exceeded_at_the_median() {
        assert_eq!(median(&[4.0, 1.0, 3.0, 2.0], None), 3.0);
        assert_eq!(median(&[4.0, 1.0, 3.0, 2.0], Some(&[1.0, 9.0, 1.0, 1.0])), 1.0);
        assert_eq!(median(&[], None), 0.0);
    }

    #[test]
    fn means_replace_the_points_of_a_cube() {
        let points = [[0.0; 3], [2.5, 0.0, 0.0], [0.5, 0.0, 0.0]];
        assert_eq!(cell_means(&points, 1.0), (vec![[0.25, 0.0, 0.0], [2.5, 0.0, 0.0]], vec![2.0, 1.0]));
        assert_eq!(cell_means(&points, 0.0), (points.to_vec(), vec![1.0; 3]));
    }

    #[test]
    fn points_on_a_quadric_stay() {
        let points: Vec<[f32; 3]> = (0..400)
            .map(|i| [(i % 20) as f32 / 20.0, (i / 20) as f32 / 20.0])
            .map(|[x, y]| [x, y, 0.1 * x * x + 0.2 * x * y])
            .collect();
        let is_near = |(v, some): (usize, &[u32])| {
            let around: Vec<(DVec3, f64)> = some.iter().map(|&w| (point(&points, w), 1.0)).collect();
            let p = point(&points, v as u32);
            let moved = (0..ROUNDS).fold(p, |p, _| project_to_surface(p, &around));
            (moved - p).abs().max_element() < 2e-4
        };
        assert!(nearest_to(&points, &points, 25).chunks_exact(25).enumerate().all(is_near));
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
