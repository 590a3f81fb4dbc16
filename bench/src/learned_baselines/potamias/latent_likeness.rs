//! The latent likeness loss.

use neural_mesh::linalg::Matrix;

// Scale of a curvature's root, so that differences are about 1.
const SCALE: f64 = 10.0;
// Added to squared distances, so that equal rows have a slope.
const LEAST: f64 = 1e-6;

/// Computes `mean of (|z_i - z_j| - t_ij)^2`, `t_ij = 10 |sqrt(k_i) - sqrt(k_j)|`, and its gradient by the latent rows.
///
/// # Shapes
/// - `latent`: n x n_latent; `curvature`: n, non-negative
/// - `offsets`: pairs are each point and the ones that many places later
pub fn latent_likeness(latent: &Matrix, curvature: &[f64], offsets: &[usize]) -> (f64, Matrix) {
    let [n, width] = latent.shape();
    // The loss is ours, because farthest points pass no gradient.
    let share = 1.0 / (n * offsets.len()).max(1) as f64;
    let (mut value, mut gradient) = (0.0, vec![0.0f64; n * width]);
    for (i, offset) in offsets.iter().flat_map(|&offset| (0..n).map(move |i| (i, offset))) {
        let j = (i + offset) % n;
        let pairs = latent.row(i).iter().zip(latent.row(j));
        let difference: Vec<f64> = pairs.map(|(&a, &b)| f64::from(a) - f64::from(b)).collect();
        let distance = (difference.iter().map(|d| d * d).sum::<f64>() + LEAST).sqrt();
        let excess = distance - SCALE * (curvature[i].sqrt() - curvature[j].sqrt()).abs();
        value += share * excess * excess;
        for (axis, d) in difference.iter().enumerate() {
            let slope = 2.0 * share * excess * d / distance;
            gradient[i * width + axis] += slope;
            gradient[j * width + axis] -= slope;
        }
    }
    (value, Matrix::new(n, width, gradient.into_iter().map(|g| g as f32).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::test_values::{assert_slopes, random};

    #[test]
    fn the_gradient_has_the_slopes_of_the_loss() {
        let latent = random(12, 3, 1);
        let curvature: Vec<f64> = (0..12).map(|i| f64::from(i * i % 7) / 30.0).collect();
        let naive = |x: &[f64]| {
            let pair = |i: usize, j: usize| {
                let square = (0..3).map(|axis| (x[3 * i + axis] - x[3 * j + axis]).powi(2)).sum::<f64>();
                ((square + 1e-6).sqrt() - 10.0 * (curvature[i].sqrt() - curvature[j].sqrt()).abs()).powi(2)
            };
            [1, 5]
                .iter()
                .flat_map(|offset| (0..12).map(move |i| (i, (i + offset) % 12)))
                .map(|(i, j)| pair(i, j))
                .sum::<f64>()
                / 24.0
        };
        let (value, gradient) = latent_likeness(&latent, &curvature, &[1, 5]);
        assert!((value - naive(&latent.data().iter().map(|&x| f64::from(x)).collect::<Vec<_>>())).abs() < 1e-9);
        assert_slopes(gradient.data(), latent.data(), naive);
    }
}
