//! Curvature kept by the samples, Sec. 4.4 (Potamias et al. 2022).

use super::Term;
use super::expected_cost::{OptionRows, expected_cost, last_costs};

/// Computes the expected squared difference in curvature between a query and its nearest sample.
///
/// Like [`coverage_of_samples`](super::coverage_of_samples), with the cost `(kappa_x - kappa_y)^2` of query x and point y;
/// the mean is divided by the variance of the queries' curvature.
///
/// # Shapes
/// - `of_queries`: kappa of each query
/// - `of_points`: kappa of each point, from [`point_curvature`](crate::spatial::point_curvature)
/// - `nearest`: n_queries x k points, nearest first, from [`nearest_to`](crate::spatial::nearest_to)
/// - `inclusion`: pi, each point's probability to be a sample
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::loss::curvature_of_samples;
/// let kappa = [0.0, 0.2];
/// let term = curvature_of_samples(&kappa, &kappa, &[0, 1, 1, 0], &[1.0, 0.5]);
/// // Point 0 is a sample. Point 1 is one half of the time; else it has lost 0.2, with a variance of 0.01.
/// assert!((term.value - 1.0).abs() < 1e-6 && (term.gradient[1] + 2.0).abs() < 1e-6);
/// ```
pub fn curvature_of_samples(of_queries: &[f32], of_points: &[f32], nearest: &[u32], inclusion: &[f32]) -> Term {
    let width = nearest.len() / of_queries.len().max(1);
    if width == 0 {
        return Term::zero(inclusion.len());
    }
    let variance = variance(of_queries);
    let scale = if variance > 0.0 { 1.0 / variance } else { 0.0 };
    let cost = |kappa: f32, x: u32| (f64::from(kappa) - f64::from(of_points[x as usize])).powi(2) * scale;
    let rows = nearest.chunks_exact(width).zip(of_queries);
    let costs: Vec<f64> = rows.flat_map(|(row, &kappa)| row.iter().map(move |&x| cost(kappa, x))).collect();
    let costs_of_none = last_costs(&costs, width);
    expected_cost(&OptionRows { options: nearest, costs: &costs, costs_of_none: &costs_of_none, width }, inclusion)
}

fn variance(values: &[f32]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().map(|&x| f64::from(x)).sum::<f64>() / n;
    values.iter().map(|&x| (f64::from(x) - mean).powi(2)).sum::<f64>() / n
}

#[cfg(test)]
mod tests {
    use super::super::test_gradients::{assert_gradient, points, uniform};
    use super::*;
    use crate::spatial::{nearest_to, point_curvature};

    #[test]
    fn agrees_with_differences() {
        let points = points(40, 1);
        let kappa = point_curvature(&points);
        let nearest = nearest_to(&points, &points[..12], 7);
        let loss = |p: &[f32]| curvature_of_samples(&kappa[..12], &kappa, &nearest, p);
        assert_gradient(&uniform(40, 2), 1e-4, loss);
        assert_eq!(loss(&[1.0; 40]).value, 0.0);
        assert!(loss(&[0.2; 40]).value > 0.0);
    }

    #[test]
    fn it_asks_for_samples_where_curvature_changes_and_not_where_it_is_flat() {
        let points: Vec<[f32; 3]> = (0..40).map(|i| [i as f32, 0.0, 0.0]).collect();
        let kappa: Vec<f32> = uniform(20, 3).into_iter().map(|x| x / 3.0).chain([0.0; 20]).collect();
        let gradient = curvature_of_samples(&kappa, &kappa, &nearest_to(&points, &points, 5), &[0.4; 40]).gradient;
        assert!(gradient[..20].iter().sum::<f32>() < -0.1);
        assert_eq!(gradient[25..], [0.0; 15]);
    }

    #[test]
    fn nothing_and_flat_things_are_fine() {
        assert_eq!(curvature_of_samples(&[], &[], &[], &[0.5]), Term::zero(1));
        assert_eq!(curvature_of_samples(&[0.1; 2], &[0.1; 2], &[0, 1, 1, 0], &[0.5; 2]), Term::zero(2));
    }
}
