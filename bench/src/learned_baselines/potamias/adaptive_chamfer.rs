//! The adaptive Chamfer distance, weighted by curvature.

use super::PointLoss;
use neural_mesh::spatial::nearest_to;

/// Returns the weights of points: half uniform, half proportional to curvature, with mean 1.
pub fn adaptive_weights(curvature: &[f64]) -> Vec<f64> {
    // The paper weighs points by curvature; the proportion is ours.
    let mean = curvature.iter().sum::<f64>() / curvature.len() as f64;
    curvature.iter().map(|kappa| if mean > 0.0 { 0.5 + 0.5 * kappa / mean } else { 1.0 }).collect()
}

/// Computes `1/|S| sum_s min_p |s - p|^2 + 1/|P| sum_p w_p min_s |p - s|^2` and its gradient by the samples.
///
/// # Shapes
/// - `samples`: n x 3, S; `points`: n_points x 3, P; `weights`: n_points; none empty
pub fn adaptive_chamfer(samples: &[[f32; 3]], points: &[[f32; 3]], weights: &[f64]) -> PointLoss {
    let mut loss = PointLoss { value: 0.0, gradient: vec![[0.0; 3]; samples.len()] };
    let mut add = |s: usize, p: usize, weight: f64| {
        let difference: [f64; 3] = std::array::from_fn(|axis| f64::from(samples[s][axis]) - f64::from(points[p][axis]));
        loss.value += weight * difference.iter().map(|d| d * d).sum::<f64>();
        loss.gradient[s].iter_mut().zip(difference).for_each(|(g, d)| *g += 2.0 * weight * d);
    };
    let [of_sample, of_point] = [samples.len(), points.len()].map(|n| 1.0 / n as f64);
    nearest_to(points, samples, 1).iter().enumerate().for_each(|(s, &p)| add(s, p as usize, of_sample));
    let nearest = nearest_to(samples, points, 1);
    nearest.iter().zip(weights).enumerate().for_each(|(p, (&s, weight))| add(s as usize, p, of_point * weight));
    loss
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::test_values::{assert_slopes, random};

    fn points(n: usize, seed: u64) -> Vec<[f32; 3]> {
        random(n, 3, seed).data().as_chunks().0.to_vec()
    }

    #[test]
    fn weights_are_half_uniform() {
        assert_eq!(adaptive_weights(&[0.0, 0.5, 0.25]), [0.5, 1.5, 1.0]);
        assert_eq!(adaptive_weights(&[0.0; 2]), [1.0; 2]);
    }

    #[test]
    fn it_agrees_with_all_pairs_and_its_gradient_with_slopes() {
        let (samples, cloud) = (points(9, 1), points(40, 2));
        let weights: Vec<f64> = (0..40).map(|i| 0.5 + f64::from(i) / 40.0).collect();
        let naive = |samples: &[f64]| {
            let distance2 =
                |s: &[f64], p: &[f32; 3]| s.iter().zip(p).map(|(s, &p)| (s - f64::from(p)).powi(2)).sum::<f64>();
            let least = |distances: &mut dyn Iterator<Item = f64>| distances.fold(f64::INFINITY, f64::min);
            let forward = samples.chunks(3).map(|s| least(&mut cloud.iter().map(|p| distance2(s, p))));
            let backward = cloud.iter().map(|p| least(&mut samples.chunks(3).map(|s| distance2(s, p))));
            forward.sum::<f64>() / 9.0 + backward.zip(&weights).map(|(d, w)| d * w).sum::<f64>() / 40.0
        };
        let found = adaptive_chamfer(&samples, &cloud, &weights);
        let flat: Vec<f64> = samples.iter().flatten().map(|&x| f64::from(x)).collect();
        assert!((found.value - naive(&flat)).abs() < 1e-9);
        let gradient: Vec<f32> = found.gradient.iter().flatten().map(|&g| g as f32).collect();
        assert_slopes(&gradient, samples.as_flattened(), naive);
    }
}
