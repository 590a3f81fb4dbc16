//! Curvature of points (Pauly et al. 2002; Potamias et al. 2022).

use super::knn::nearest_neighbours;
use crate::geometry::eigenvalues;
use crate::parallel;
use glam::{DVec3, Vec3};

const NEIGHBOURS: usize = 10;
/// Fewest points of a thread at once.
const ROWS: usize = 64;

/// Computes the curvature of each point from the covariance of the point and its 10 nearest.
///
/// `kappa = l0 / (l0 + l1 + l2)` of the ascending eigenvalues, smoothed over these points with a Gaussian whose
/// deviation is their mean distance. Independent of scale: 0 in a plane, 1/3 for isotropic points.
///
/// # Shapes
/// - `points`: n x 3, finite
/// - returns n numbers in 0..=1/3; 0 without neighbours
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::spatial::point_curvature;
/// let plane: Vec<[f32; 3]> = (0..100).map(|i| [(i % 10) as f32, (i / 10) as f32, 0.0]).collect();
/// assert!(point_curvature(&plane).iter().all(|kappa| *kappa < 1e-6));
/// ```
pub fn point_curvature(points: &[[f32; 3]]) -> Vec<f32> {
    let neighbours = nearest_neighbours(points, NEIGHBOURS);
    let width = neighbours.len() / points.len().max(1);
    if width == 0 {
        return vec![0.0; points.len()];
    }
    let row = |i: usize| &neighbours[i * width..][..width];
    let raw: Vec<f64> = parallel::map(points.len(), ROWS, |i| flatness(points, i, row(i)));
    parallel::map(points.len(), ROWS, |i| smooth(points, &raw, i, row(i)) as f32)
}

fn offsets(points: &[[f32; 3]], i: usize, row: &[u32]) -> Vec<DVec3> {
    let point = |i: usize| Vec3::from(points[i]).as_dvec3();
    row.iter().map(|&j| point(j as usize) - point(i)).collect()
}

fn flatness(points: &[[f32; 3]], i: usize, row: &[u32]) -> f64 {
    let others = offsets(points, i, row);
    let mean = others.iter().sum::<DVec3>() / (others.len() + 1) as f64;
    let mut covariance = [0.0; 6];
    for d in others.into_iter().chain([DVec3::ZERO]).map(|d| d - mean) {
        let products = [d.x * d.x, d.x * d.y, d.x * d.z, d.y * d.y, d.y * d.z, d.z * d.z];
        covariance.iter_mut().zip(products).for_each(|(sum, product)| *sum += product);
    }
    let [least, ..] = eigenvalues(covariance);
    let trace = covariance[0] + covariance[3] + covariance[5];
    if trace > 0.0 { (least / trace).clamp(0.0, 1.0 / 3.0) } else { 0.0 }
}

fn smooth(points: &[[f32; 3]], raw: &[f64], i: usize, row: &[u32]) -> f64 {
    let distances: Vec<f64> = offsets(points, i, row).into_iter().map(DVec3::length).collect();
    let deviation = distances.iter().sum::<f64>() / distances.len() as f64;
    let weight = |d: &f64| if deviation > 0.0 { (-0.5 * (d / deviation).powi(2)).exp() } else { 1.0 };
    let others = distances.iter().zip(row).map(|(d, &j)| (weight(d), raw[j as usize]));
    let (weights, sum) = others.fold((1.0, raw[i]), |(weights, sum), (w, kappa)| (weights + w, sum + w * kappa));
    sum / weights
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sphere(n: usize, radius: f32) -> Vec<[f32; 3]> {
        let spiral_point = |i: usize| {
            let z = 1.0 - (2 * i + 1) as f32 / n as f32;
            let (r, turn) = ((1.0 - z * z).sqrt(), i as f32 * 2.399_963_1);
            [radius * r * turn.cos(), radius * r * turn.sin(), radius * z]
        };
        (0..n).map(spiral_point).collect()
    }

    #[test]
    fn a_sphere_is_curved_alike_and_less_the_denser_it_is_sampled() {
        let [coarse, dense] = [200, 3200].map(|n| point_curvature(&sphere(n, 1.0)));
        let mean = |all: &[f32]| all.iter().sum::<f32>() / all.len() as f32;
        assert!(coarse.iter().all(|kappa| (kappa / mean(&coarse) - 1.0).abs() < 0.5));
        // The height of a cap grows as its squared width, so the share of the variance of heights falls as 1 / n.
        assert!((10.0..24.0).contains(&(mean(&coarse) / mean(&dense))), "{}", mean(&coarse) / mean(&dense));
    }

    #[test]
    fn scale_does_not_matter_and_an_edge_is_curved() {
        let (one, large) = (point_curvature(&sphere(100, 1.0)), point_curvature(&sphere(100, 1024.0)));
        assert!(one.iter().zip(&large).all(|(a, b)| (a - b).abs() < 1e-6));
        let roof: Vec<[f32; 3]> =
            (0..400).map(|i| ((i % 20) as f32 - 9.5, (i / 20) as f32)).map(|(x, y)| [x, y, -x.abs()]).collect();
        let kappa = point_curvature(&roof);
        assert!(kappa[209] > 0.01 && kappa[202] < 1e-6, "{} {}", kappa[209], kappa[202]);
    }

    #[test]
    fn few_and_equal_points_are_fine() {
        assert!(point_curvature(&[]).is_empty());
        assert_eq!(point_curvature(&[[1.0; 3]]), [0.0]);
        assert_eq!(point_curvature(&[[1.0; 3]; 20]), [0.0; 20]);
        assert_eq!(point_curvature(&[[0.0; 3], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0]]), [0.0; 3]);
    }
}
