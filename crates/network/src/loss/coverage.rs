//! Distance from the original surface to the kept faces, trained instead of Eq. (8).

use super::Term;
use super::expected_cost::{OptionRows, expected_cost};
use super::triangles::{barycenters, corners_f64, to_f64};
use crate::geometry::nearest_on_triangle::nearest_weights_f64;
use crate::parallel;
use crate::spatial::nearest_to;
use glam::DVec3;

/// Points that a thread takes together.
const ROWS: usize = 64;

/// The triangles closest to each point of the original surface.
#[derive(Clone, Debug, PartialEq)]
pub struct NearTriangles {
    /// n_points x `width` triangles, nearest first.
    pub triangles: Vec<u32>,
    /// n_points x `width` squared distances, ascending per row.
    pub distances2: Vec<f64>,
    /// Triangles per point.
    pub width: usize,
}

/// Finds the k triangles closest to each point of the original surface, among the 2 k with the nearest barycenters.
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::loss::near_triangles;
/// let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
/// let near = near_triangles(&points, &[[0, 1, 2], [1, 2, 3]], &[[1.0, 1.0, 2.0]], 8);
/// assert_eq!((near.triangles, near.width), (vec![1, 0], 2));
/// assert_eq!(near.distances2, [4.0, 4.5]);
/// ```
pub fn near_triangles(points: &[[f32; 3]], triangles: &[[u32; 3]], surface: &[[f32; 3]], k: usize) -> NearTriangles {
    let width = k.min(triangles.len());
    if width == 0 {
        return NearTriangles { triangles: Vec::new(), distances2: Vec::new(), width };
    }
    let by_barycenter = nearest_to(&barycenters(points, triangles), surface, 2 * k);
    let searched = by_barycenter.len() / surface.len().max(1);
    let row = |row: usize| {
        let x = surface[row];
        let distance2 = |&t: &u32| (distance2_to(corners_f64(points, triangles[t as usize]), to_f64(x)), t);
        let mut found: Vec<(f64, u32)> = by_barycenter[row * searched..][..searched].iter().map(distance2).collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found.truncate(width);
        found
    };
    let (distances2, triangles) = parallel::flat_map(0..surface.len(), ROWS, row).unzip();
    NearTriangles { triangles, distances2, width }
}

fn distance2_to(corners: [DVec3; 3], x: DVec3) -> f64 {
    let [u, v, w] = nearest_weights_f64(x, corners);
    x.distance_squared(corners[0] * u + corners[1] * v + corners[2] * w)
}

/// Computes the mean over the surface points of the expected squared distance to the nearest kept face.
///
/// Per point, k and j run over its nearest triangles, nearest first:
///
/// `sum_k min(d_k^2, penalty) p_k prod_{j<k} (1 - p_j) + penalty prod_j (1 - p_j)`
///
/// # Shapes
/// - `penalty`: squared length, the cost of an uncovered point
/// - `probabilities`: n_triangles
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::loss::{NearTriangles, coverage};
/// let near = NearTriangles { triangles: vec![1, 0], distances2: vec![0.0, 2.0], width: 2 };
/// let term = coverage(&near, 8.0, &[0.5, 0.5]);
/// assert_eq!((term.value, term.gradient), (0.5 * 0.5 * 2.0 + 0.25 * 8.0, vec![-3.0, -5.0]));
/// ```
pub fn coverage(near: &NearTriangles, penalty: f64, probabilities: &[f32]) -> Term {
    let NearTriangles { triangles, distances2, width } = near;
    // Components without a sample, however far, count as uncovered and no more.
    let costs: Vec<f64> = distances2.iter().map(|d2| d2.min(penalty)).collect();
    let costs_of_none = vec![penalty; costs.len() / width.max(&1)];
    let rows = OptionRows { options: triangles, costs: &costs, costs_of_none: &costs_of_none, width: *width };
    expected_cost(&rows, probabilities)
}

#[cfg(test)]
mod tests {
    use super::super::test_gradients::{assert_gradient, points, triangles, uniform};
    use super::*;

    #[test]
    fn agrees_with_all_triangles_and_with_differences() {
        let (points, surface) = (points(20, 1), points(25, 2));
        let triangles = triangles(16, 20, 3);
        // The 2 k = 16 candidates by barycenter are all triangles here.
        let near = near_triangles(&points, &triangles, &surface, 8);
        for (row, &x) in near.distances2.chunks(8).zip(&surface) {
            let mut all: Vec<f64> =
                triangles.iter().map(|&t| distance2_to(corners_f64(&points, t), to_f64(x))).collect();
            all.sort_by(f64::total_cmp);
            assert_eq!(row, &all[..8]);
        }
        assert_gradient(&uniform(16, 4), 1e-4, |p| coverage(&near, 3.0, p));
    }

    #[test]
    fn more_faces_cover_more_and_the_empty_mesh_is_the_worst() {
        let points = points(20, 5);
        let near = near_triangles(&points, &triangles(16, 20, 6), &points, 4);
        let loss = |p: f32| coverage(&near, 3.0, &[p; 16]);
        assert_eq!(loss(0.0).value, 3.0);
        assert!(loss(0.0).value > loss(0.5).value && loss(0.5).value > loss(1.0).value);
        assert!(loss(0.5).gradient.iter().all(|&g| g <= 0.0));
    }

    #[test]
    fn nothing_and_triangles_without_area_are_fine() {
        assert_eq!(coverage(&near_triangles(&[], &[], &[], 4), 1.0, &[]), Term::zero(0));
        assert_eq!(coverage(&near_triangles(&[], &[], &[[0.0; 3]], 4), 1.0, &[]), Term::zero(0));
        let near = near_triangles(&[[0.0; 3]; 3], &[[0, 1, 2]], &[[1.0, 0.0, 0.0]], 4);
        assert_eq!(coverage(&near, 4.0, &[0.5]), Term { value: 2.5, gradient: vec![-3.0] });
    }
}
