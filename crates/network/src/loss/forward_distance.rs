//! Forward surface distance, Eq. (7).

use super::Term;
use super::triangles::{barycenters, distance2};
use crate::spatial::nearest_to;

/// Computes `min_b |b^ - b|^2` of Eq. (7) from each candidate's barycenter b^ to the original faces' barycenters.
///
/// # Shapes
/// - `original`: barycenters of the original faces; without any, distances are 0
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::loss::forward_distances;
/// let points = [[0.0; 3], [3.0, 0.0, 0.0], [0.0, 3.0, 0.0]];
/// assert_eq!(forward_distances(&points, &[[0, 1, 2]], &[[1.0, 1.0, 2.0], [9.0; 3]]), [4.0]);
/// ```
pub fn forward_distances(points: &[[f32; 3]], triangles: &[[u32; 3]], original: &[[f32; 3]]) -> Vec<f64> {
    let centers = barycenters(points, triangles);
    if original.is_empty() {
        return vec![0.0; triangles.len()];
    }
    let nearest = nearest_to(original, &centers, 1);
    centers.iter().zip(nearest).map(|(&center, b)| distance2(center, original[b as usize])).collect()
}

/// Computes Eq. (7), `sum_b^ p_b^ min_b |b^ - b|^2`, divided by the number of candidates.
///
/// Its minimum is the empty mesh: all probabilities 0.
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::loss::forward_distance;
/// let term = forward_distance(&[4.0, 2.0], &[0.25, 1.0]);
/// assert_eq!((term.value, term.gradient), (1.5, vec![2.0, 1.0]));
/// ```
pub fn forward_distance(distances: &[f64], probabilities: &[f32]) -> Term {
    Term::mean_product(distances, probabilities)
}

#[cfg(test)]
mod tests {
    use super::super::test_gradients::{assert_gradient, points, triangles, uniform};
    use super::*;

    #[test]
    fn agrees_with_all_pairs_and_with_differences() {
        let (points, original) = (points(30, 1), points(40, 2));
        let triangles = triangles(12, 30, 3);
        let distances = forward_distances(&points, &triangles, &original);
        for (center, found) in barycenters(&points, &triangles).into_iter().zip(&distances) {
            let expected = original.iter().map(|&b| distance2(center, b)).fold(f64::INFINITY, f64::min);
            assert_eq!(*found, expected);
        }
        assert_gradient(&uniform(12, 4), 1e-4, |p| forward_distance(&distances, p));
    }

    #[test]
    fn the_empty_mesh_is_its_minimum() {
        let distances = [0.5, 0.0, 0.25];
        assert_eq!(forward_distance(&distances, &[0.0; 3]).value, 0.0);
        assert!(forward_distance(&distances, &[0.5; 3]).gradient.iter().all(|&g| g >= 0.0));
    }

    #[test]
    fn nothing_is_fine() {
        assert_eq!(forward_distance(&forward_distances(&[], &[], &[]), &[]), Term::zero(0));
        assert_eq!(forward_distances(&[[0.0; 3]], &[[0, 0, 0]], &[]), [0.0]);
    }
}
