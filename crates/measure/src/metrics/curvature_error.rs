//! Curvature error between point sets (Potamias et al., point-cloud simplification), as in Table 2.

use crate::parallel;
use crate::spatial::{nearest_to, point_curvature};

const CHUNK: usize = 512;

/// Measures `mean_a (k(a) - k(a'))^2 + mean_b (k(b) - k(b'))^2`; `None` if a set is empty.
///
/// `a'` is the nearest point of the other set, `k` the [`point_curvature`] of a point within its own set.
///
/// ```
/// # use neural_mesh_measure as neural_mesh;
/// use neural_mesh::{mesh::shapes, metrics::curvature_error};
/// let sphere = shapes::icosphere(3);
/// assert_eq!(curvature_error(sphere.positions(), sphere.positions()), Some(0.0));
/// assert!(curvature_error(sphere.positions(), shapes::icosphere(1).positions()).unwrap() > 1e-4);
/// ```
pub fn curvature_error(a: &[[f32; 3]], b: &[[f32; 3]]) -> Option<f64> {
    if a.is_empty() || b.is_empty() {
        return None;
    }
    let [curvature_a, curvature_b] = [a, b].map(point_curvature);
    let forward = mean_squared_difference(&curvature_a, &curvature_b, &nearest_to(b, a, 1));
    Some(forward + mean_squared_difference(&curvature_b, &curvature_a, &nearest_to(a, b, 1)))
}

fn mean_squared_difference(from: &[f32], to: &[f32], nearest: &[u32]) -> f64 {
    let sums = parallel::chunks(from, CHUNK, |chunk, values| {
        let pairs = values.iter().zip(&nearest[chunk * CHUNK..]);
        pairs.map(|(value, &at)| f64::from(value - to[at as usize]).powi(2)).sum::<f64>()
    });
    sums.iter().sum::<f64>() / from.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ridge(height: f32) -> Vec<[f32; 3]> {
        let bump_point = |i: i32, j: i32| [i as f32, j as f32, height * (-(i * i) as f32 / 30.0).exp()];
        (-12..=12).flat_map(|i| (-12..=12).map(move |j| bump_point(i, j))).collect()
    }

    #[test]
    fn a_plane_against_a_smaller_plane_has_none() {
        let plane = ridge(0.0);
        assert!(curvature_error(&plane, &plane[..100]).unwrap() < 1e-12);
    }

    #[test]
    fn it_grows_with_the_curvature_that_is_missing_and_is_symmetric() {
        let errors = [0.0, 0.5, 1.0, 2.0].map(|height| curvature_error(&ridge(2.0), &ridge(height)).unwrap());
        assert!(errors.is_sorted_by(|a, b| a > b) && errors[3] == 0.0, "{errors:?}");
        assert_eq!(curvature_error(&ridge(0.5), &ridge(2.0)), Some(errors[1]));
    }

    #[test]
    fn partners_by_hand() {
        assert_eq!(mean_squared_difference(&[1.0, 4.0], &[3.0], &[0, 0]), 2.5);
        assert_eq!(mean_squared_difference(&[3.0], &[1.0, 4.0], &[1]), 1.0);
    }
}
