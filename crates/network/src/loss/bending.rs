//! Bending of the surface that the samples miss, an addition to the paper.

use super::Term;
use super::expected_cost::relative_cost;
use glam::DVec3;

/// Computes the expected squared distance between a query and its nearest sample along their normals.
///
/// Like [`coverage_of_samples`](super::coverage_of_samples), with the cost `((x - y).n_x)^2 / 2 + ((x - y).n_y)^2 / 2` of
/// query x and point y instead of their squared distance.
///
/// # Shapes
/// - `normals`: unit vectors
/// - `nearest`: n_queries x k points, nearest first, from [`nearest_to`](crate::spatial::nearest_to)
/// - `inclusion`: pi of each point
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::loss::bending_of_samples;
/// // Two points of a floor, one above it.
/// let points = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 2.0]];
/// let normals = [[0.0, 0.0, 1.0]; 3];
/// let term = bending_of_samples(&points, &normals, &[0], &[0, 1, 2], &[0.0, 0.5, 0.5]);
/// // Costs 0, 0, 4: half of the time point 1 is the nearest sample.
/// assert_eq!((term.value, term.gradient), (0.5, vec![-0.5, -1.0, 0.0]));
/// ```
pub fn bending_of_samples(
    points: &[[f32; 3]],
    normals: &[[f32; 3]],
    queries: &[u32],
    nearest: &[u32],
    inclusion: &[f32],
) -> Term {
    let width = nearest.len() / queries.len().max(1);
    if width == 0 {
        return Term::zero(inclusion.len());
    }
    let rows = nearest.chunks_exact(width).zip(queries);
    let costs: Vec<f64> = rows.flat_map(|(row, &x)| row.iter().map(move |&y| cost(points, normals, [x, y]))).collect();
    relative_cost(nearest, costs, width, inclusion)
}

fn cost(points: &[[f32; 3]], normals: &[[f32; 3]], pair: [u32; 2]) -> f64 {
    let [p, q] = pair.map(|v| DVec3::from(points[v as usize].map(f64::from)));
    let along = pair.map(|v| DVec3::from(normals[v as usize].map(f64::from)).dot(p - q));
    0.5 * (along[0] * along[0] + along[1] * along[1])
}

#[cfg(test)]
mod tests {
    use super::super::test_gradients::{assert_gradient, points, uniform};
    use super::*;
    use crate::spatial::nearest_to;

    #[test]
    fn agrees_with_differences() {
        let (points, normals) = (points(40, 1), points(40, 2));
        let queries: Vec<u32> = (0..12).collect();
        let nearest = nearest_to(&points, &points[..12], 7);
        assert_gradient(&uniform(40, 3), 1e-4, |p| bending_of_samples(&points, &normals, &queries, &nearest, p));
    }

    #[test]
    fn a_plane_needs_no_sample() {
        let points: Vec<[f32; 3]> = (0..20).map(|i| [i as f32, (i * i % 7) as f32, 0.0]).collect();
        let nearest = nearest_to(&points, &points[..5], 6);
        let term = bending_of_samples(&points, &[[0.0, 0.0, 1.0]; 20], &[0, 1, 2, 3, 4], &nearest, &[0.3; 20]);
        assert_eq!((term.value, term.gradient), (0.0, vec![0.0; 20]));
    }
}
