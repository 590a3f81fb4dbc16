//! The probabilistic Chamfer distance of Eq. (6), and the form used in training.

use super::Term;
use super::expected_cost::{last_costs, relative_cost};
use super::triangles::distance2;
use crate::spatial::nearest_to;

/// Computes Eq. (6) as printed: `sum_y p(y) min_x |x - y|^2 + sum_x p(y) min_y |x - y|^2`.
///
/// In the second sum, y is the sample nearest to x. That sum falls when mass moves AWAY from badly covered samples, so
/// [`coverage_of_samples`] is trained instead.
///
/// # Shapes
/// - `probabilities`: n_samples
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::loss::probabilistic_chamfer;
/// let points = [[0.0; 3], [1.0, 0.0, 0.0], [5.0, 0.0, 0.0], [7.0, 0.0, 0.0]];
/// let samples = [points[0], points[2]];
/// let term = probabilistic_chamfer(&points, &samples, &[0.5, 0.5]);
/// assert_eq!((term.value, term.gradient), (2.5, vec![1.0, 4.0]));
/// ```
pub fn probabilistic_chamfer(points: &[[f32; 3]], samples: &[[f32; 3]], probabilities: &[f32]) -> Term {
    if points.is_empty() || samples.is_empty() {
        return Term::zero(samples.len());
    }
    let mut weights = vec![0.0f64; samples.len()];
    for (y, x) in nearest_to(points, samples, 1).into_iter().enumerate() {
        weights[y] += distance2(points[x as usize], samples[y]);
    }
    for (x, y) in nearest_to(samples, points, 1).into_iter().enumerate() {
        weights[y as usize] += distance2(points[x], samples[y as usize]);
    }
    let value = weights.iter().zip(probabilities).map(|(w, &p)| w * f64::from(p)).sum();
    Term { value, gradient: weights.into_iter().map(|w| w as f32).collect() }
}

/// Computes the expected squared distance from a query to its nearest sample, with independent inclusion probabilities.
///
/// Per query, over its k nearest points: `sum_k d_k^2 pi_k prod_{j<k} (1 - pi_j)`; the last distance counts if none is a
/// sample. The mean is divided by the mean of the last squared distances, which gives 0..=1.
///
/// # Shapes
/// - `nearest`: n_queries x k points, nearest first, from [`nearest_to`]; k a few times n / n_samples
/// - `inclusion`: pi, each point's probability to be a sample
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::{loss::coverage_of_samples, spatial::nearest_to};
/// let points = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
/// let nearest = nearest_to(&points, &points[..1], 3);
/// let term = coverage_of_samples(&points, &points[..1], &nearest, &[0.5; 3]);
/// assert_eq!(term.value, (0.25 * 1.0 + 0.25 * 4.0) / 4.0);
/// assert_eq!(term.gradient, [-0.625, -0.375, 0.0]);
/// ```
pub fn coverage_of_samples(points: &[[f32; 3]], queries: &[[f32; 3]], nearest: &[u32], inclusion: &[f32]) -> Term {
    let width = nearest.len() / queries.len().max(1);
    if width == 0 {
        return Term::zero(inclusion.len());
    }
    relative_cost(nearest, squared_distances(points, queries, nearest), width, inclusion)
}

fn squared_distances(points: &[[f32; 3]], queries: &[[f32; 3]], nearest: &[u32]) -> Vec<f64> {
    let width = nearest.len() / queries.len().max(1);
    let row = |(row, &q): (&[u32], &[f32; 3])| row.iter().map(move |&x| distance2(points[x as usize], q)).collect();
    nearest.chunks_exact(width.max(1)).zip(queries).flat_map::<Vec<f64>, _>(row).collect()
}

/// Computes the expected squared distance from a sample to the nearest original point: the other half of the Chamfer distance.
///
/// It is 0 unless noise has moved the points. `sum pi_y d_y^2 / sum pi_y`, in the unit of [`coverage_of_samples`].
///
/// # Shapes
/// - `points`: n x 3; `originals`: m x 3
/// - `queries`, `nearest`, `inclusion`: those of [`coverage_of_samples`]
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::loss::deviation_of_samples;
/// let (points, originals) = ([[0.0, 0.0, 1.0], [2.0, 0.0, 0.0]], [[0.0; 3], [2.0, 0.0, 0.0]]);
/// let term = deviation_of_samples(&points, &originals, (&originals[..1], &[0, 1]), &[0.5; 2]);
/// assert_eq!((term.value, term.gradient), (0.5 / 4.0, vec![0.125, -0.125]));
/// ```
pub fn deviation_of_samples(
    points: &[[f32; 3]],
    originals: &[[f32; 3]],
    (queries, nearest): (&[[f32; 3]], &[u32]),
    inclusion: &[f32],
) -> Term {
    let expected: f64 = inclusion.iter().map(|&pi| f64::from(pi)).sum();
    if originals.is_empty() || nearest.is_empty() || expected == 0.0 {
        return Term::zero(inclusion.len());
    }
    let lasts = last_costs(&squared_distances(points, queries, nearest), nearest.len() / queries.len().max(1));
    let unit = lasts.iter().sum::<f64>() / lasts.len().max(1) as f64;
    let scale = if unit > 0.0 { 1.0 / (unit * expected) } else { 0.0 };
    let partners = nearest_to(originals, points, 1);
    let squares: Vec<f64> = points.iter().zip(partners).map(|(&y, x)| distance2(originals[x as usize], y)).collect();
    let mean = squares.iter().zip(inclusion).map(|(d2, &pi)| d2 * f64::from(pi)).sum::<f64>() / expected;
    Term { value: mean * scale * expected, gradient: squares.iter().map(|d2| ((d2 - mean) * scale) as f32).collect() }
}

#[cfg(test)]
mod tests {
    use super::super::test_gradients::{assert_gradient, points, uniform};
    use super::super::{inclusion, inclusion_gradient};
    use super::*;

    #[test]
    fn the_print_agrees_with_all_pairs_also_where_samples_are_no_points() {
        let (points, samples, p) = (points(50, 1), points(9, 2), uniform(9, 3));
        let nearest = |from: [f32; 3], to: &[[f32; 3]]| {
            let each = to.iter().map(|&x| distance2(from, x)).enumerate();
            each.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap()
        };
        let first: f64 = samples.iter().zip(&p).map(|(&y, &p)| f64::from(p) * nearest(y, &points).1).sum();
        let of_point = |&x: &[f32; 3]| {
            let (y, d2) = nearest(x, &samples);
            f64::from(p[y]) * d2
        };
        let second: f64 = points.iter().map(of_point).sum();
        assert!((probabilistic_chamfer(&points, &samples, &p).value - first - second).abs() < 1e-9);
        assert_gradient(&p, 1e-5, |p| probabilistic_chamfer(&points, &samples, p));
    }

    #[test]
    fn the_print_pushes_mass_away_from_badly_covered_regions_and_coverage_toward_them() {
        let far = (0..20).map(|i| [i as f32, 0.0, 0.0]);
        let near = (0..20).map(|i| [100.0 + 0.01 * i as f32, 0.0, 0.0]);
        let points: Vec<[f32; 3]> = far.chain(near).collect();
        let printed = probabilistic_chamfer(&points, &[points[0], points[20]], &[0.5, 0.5]).gradient;
        assert!(printed[0] > printed[1], "descent under a softmax lowers p of the badly covered region");
        let nearest = nearest_to(&points, &points, 20);
        let even = inclusion(&[0.0; 40], 4);
        let term = coverage_of_samples(&points, &points, &nearest, &even.probabilities);
        let to_scores = inclusion_gradient(&even, &term.gradient);
        assert!(to_scores[..20].iter().sum::<f32>() < 0.0 && to_scores[20..].iter().sum::<f32>() > 0.0);
    }

    #[test]
    fn coverage_agrees_with_differences_and_reaches_both_ends() {
        let points = points(40, 4);
        let nearest = nearest_to(&points, &points[..15], 8);
        let loss = |p: &[f32]| coverage_of_samples(&points, &points[..15], &nearest, p);
        assert_gradient(&uniform(40, 5), 1e-4, loss);
        assert_eq!(loss(&[1.0; 40]).value, 0.0);
        assert!((loss(&[0.0; 40]).value - 1.0).abs() < 1e-12);
    }

    #[test]
    fn deviation_agrees_with_differences_and_is_least_for_points_of_the_original() {
        let (points, originals) = (points(40, 7), points(40, 8));
        let nearest = nearest_to(&points, &originals[..15], 8);
        let loss = |p: &[f32]| deviation_of_samples(&points, &originals, (&originals[..15], &nearest), p);
        assert_gradient(&uniform(40, 9), 1e-4, loss);
        assert_eq!(
            deviation_of_samples(&points, &points, (&originals[..15], &nearest), &uniform(40, 9)),
            Term::zero(40)
        );
    }

    #[test]
    fn nothing_and_equal_points_are_fine() {
        assert_eq!(probabilistic_chamfer(&[], &[], &[]), Term::zero(0));
        assert_eq!(coverage_of_samples(&[], &[], &[], &[]), Term::zero(0));
        let equal = [[1.0; 3]; 5];
        assert_eq!(coverage_of_samples(&equal, &equal, &nearest_to(&equal, &equal, 3), &[0.5; 5]), Term::zero(5));
    }
}
