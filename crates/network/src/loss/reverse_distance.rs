//! Reverse surface distance as printed, Eq. (8), whose minimum is the empty mesh.

use super::Term;
use super::triangles::{barycenters, corners_f64, distance2, spread_points};
use crate::parallel;
use crate::spatial::nearest_to;

/// Triangles that a thread takes together.
const ROWS: usize = 64;

/// Squared distances of Eq. (8), which do not depend on probabilities.
#[derive(Clone, Debug, PartialEq)]
pub struct ReverseDistances {
    /// Mean squared distance from each triangle's points to the nearest original points, n_triangles.
    pub to_original: Vec<f64>,
    /// Triangles among the k nearest to a point of each triangle, ascending, without itself.
    pub near: Vec<Vec<u32>>,
    /// Mean over the points y of `|x_t - y|^2 / k` for each triangle t in `near`, with barycenter x_t. Points count 0
    /// if t is not among their k nearest.
    pub to_near: Vec<Vec<f64>>,
}

/// Measures the squared distances of Eq. (8) from points y on each triangle.
///
/// # Shapes
/// - `original`: the original vertices as in the paper, or denser points
/// - `per_triangle`: points per triangle, at least 1, in a fixed pattern
/// - `k`: nearest other triangles per point
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::loss::reverse_distances;
/// let points = [[0.0; 3], [3.0, 0.0, 0.0], [0.0, 3.0, 0.0], [3.0, 3.0, 0.0]];
/// let found = reverse_distances(&points, &[[0, 1, 2], [1, 2, 3]], &points, 1, 5);
/// assert_eq!(found.near, [[1], [0]]);
/// assert!((found.to_near[0][0] - 2.0).abs() < 1e-6 && (found.to_original[0] - 2.0).abs() < 1e-6);
/// ```
pub fn reverse_distances(
    points: &[[f32; 3]],
    triangles: &[[u32; 3]],
    original: &[[f32; 3]],
    per_triangle: usize,
    k: usize,
) -> ReverseDistances {
    let per_triangle = per_triangle.max(1);
    let centers = barycenters(points, triangles);
    let on = |&triangle: &[u32; 3]| spread_points(corners_f64(points, triangle), per_triangle);
    let ys: Vec<[f32; 3]> = parallel::flat_map(0..triangles.len(), ROWS, |t| on(&triangles[t])).collect();
    let nearest_original = nearest_to(original, &ys, 1);
    let nearest_triangles = nearest_to(&centers, &ys, k + 1);
    let width = nearest_triangles.len() / ys.len().max(1);
    let of_triangle = |t: usize| {
        let mut found = Vec::new();
        for y in t * per_triangle..(t + 1) * per_triangle {
            let others = nearest_triangles[y * width..(y + 1) * width].iter().filter(|&&u| u as usize != t).take(k);
            let n_others = others.clone().count() as f64;
            let share = n_others * per_triangle as f64;
            found.extend(others.map(|&u| (u, distance2(centers[u as usize], ys[y]) / share)));
        }
        merge_equal(found)
    };
    let (near, to_near) = parallel::map(triangles.len(), ROWS, of_triangle).into_iter().unzip();
    let to_original = |t: usize| {
        let distance = |y: usize| nearest_original.get(y).map_or(0.0, |&x| distance2(original[x as usize], ys[y]));
        (t * per_triangle..(t + 1) * per_triangle).map(distance).sum::<f64>() / per_triangle as f64
    };
    ReverseDistances { to_original: (0..triangles.len()).map(to_original).collect(), near, to_near }
}

fn merge_equal(mut found: Vec<(u32, f64)>) -> (Vec<u32>, Vec<f64>) {
    found.sort_by_key(|&(t, _)| t);
    let groups = found.chunk_by(|a, b| a.0 == b.0);
    groups.map(|group| (group[0].0, group.iter().map(|(_, d2)| d2).sum::<f64>())).unzip()
}

/// Computes Eq. (8), divided by the number of points.
///
/// `sum_y p_y min_x |x - y|^2 + (1 - p_y) 1/k sum_k p_{t_k} |x_{t_k} - y|^2`, with p_y the probability of y's triangle
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::loss::{ReverseDistances, reverse_distance};
/// let distances = ReverseDistances {
///     to_original: vec![1.0, 3.0],
///     near: vec![vec![1], vec![0]],
///     to_near: vec![vec![4.0], vec![8.0]],
/// };
/// let term = reverse_distance(&distances, &[0.5, 0.0]);
/// assert_eq!((term.value, term.gradient), ((0.5 + 0.5 * 8.0) / 2.0, vec![4.5, (3.0 + 2.0 - 4.0) / 2.0]));
/// assert_eq!(reverse_distance(&distances, &[0.0, 0.0]).value, 0.0);
/// ```
pub fn reverse_distance(distances: &ReverseDistances, probabilities: &[f32]) -> Term {
    let p = |t: usize| f64::from(probabilities[t]);
    let mut gradient = distances.to_original.clone();
    let mut sum = 0.0;
    for (t, (near, to_near)) in distances.near.iter().zip(&distances.to_near).enumerate() {
        let replaced: f64 = near.iter().zip(to_near).map(|(&u, d2)| p(u as usize) * d2).sum();
        sum += p(t) * distances.to_original[t] + (1.0 - p(t)) * replaced;
        gradient[t] -= replaced;
        near.iter().zip(to_near).for_each(|(&u, d2)| gradient[u as usize] += (1.0 - p(t)) * d2);
    }
    Term::mean(sum, &gradient, distances.to_original.len())
}

#[cfg(test)]
mod tests {
    use super::super::test_gradients::{assert_gradient, points, triangles, uniform};
    use super::*;

    fn naive(points: &[[f32; 3]], triangles: &[[u32; 3]], original: &[[f32; 3]], n: usize, k: usize, p: &[f32]) -> f64 {
        let centers = barycenters(points, triangles);
        let mut sum = 0.0;
        for (t, &triangle) in triangles.iter().enumerate() {
            for y in spread_points(corners_f64(points, triangle), n) {
                let nearest = original.iter().map(|&x| distance2(x, y)).fold(f64::INFINITY, f64::min);
                let mut others: Vec<(f64, f64)> = (0..triangles.len())
                    .filter(|&u| u != t)
                    .map(|u| (distance2(centers[u], y), f64::from(p[u])))
                    .collect();
                others.sort_by(|a, b| a.0.total_cmp(&b.0));
                let replaced = others[..k].iter().map(|(d2, p)| d2 * p).sum::<f64>() / k as f64;
                sum += f64::from(p[t]) * nearest + (1.0 - f64::from(p[t])) * replaced;
            }
        }
        sum / (n * triangles.len()) as f64
    }

    #[test]
    fn agrees_with_the_print_and_with_differences() {
        let (points, original, p) = (points(20, 1), points(30, 2), uniform(15, 3));
        let triangles = triangles(15, 20, 4);
        let distances = reverse_distances(&points, &triangles, &original, 7, 4);
        let expected = naive(&points, &triangles, &original, 7, 4, &p);
        assert!((reverse_distance(&distances, &p).value - expected).abs() < 1e-9);
        assert_gradient(&p, 1e-4, |p| reverse_distance(&distances, p));
    }

    #[test]
    fn the_empty_mesh_is_its_minimum() {
        let points = points(20, 5);
        let distances = reverse_distances(&points, &triangles(15, 20, 6), &points, 3, 4);
        assert_eq!(reverse_distance(&distances, &[0.0; 15]).value, 0.0);
        assert!(reverse_distance(&distances, &[0.5; 15]).value > 0.0);
    }

    #[test]
    fn nothing_one_triangle_and_no_area_are_fine() {
        assert_eq!(reverse_distance(&reverse_distances(&[], &[], &[], 10, 20), &[]), Term::zero(0));
        let alone = reverse_distances(&[[1.0; 3]; 3], &[[0, 1, 2]], &[], 10, 20);
        assert_eq!(reverse_distance(&alone, &[0.5]), Term::zero(1));
    }
}
