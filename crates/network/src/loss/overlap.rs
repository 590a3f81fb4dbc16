//! Overlapping triangles in nearly one plane (Sec. 3.4).

use super::conflicts::near_pairs;
use super::triangles::{corners_f64, spread_points, to_f64};
use crate::geometry::triangle::area_normal_f64;
use crate::linalg::Csr;
use glam::DVec3;

/// Settings of the overlap search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OverlapSettings {
    /// Test points per triangle, in a fixed pattern.
    pub per_triangle: usize,
    /// Largest distance of a point from a triangle's plane, as a share of the square root of the triangle's area.
    pub flatness: f64,
}

/// Finds pairs (t, u) of nearby triangles where a test point of t lies over u.
///
/// Point y lies over triangle a b c if it is close and the areas of y' a b, y' b c and y' c a, for the projection y', sum to
/// that of a b c. Triangles without area, and pairs at more than 25 degrees, are ignored.
///
/// # Shapes
/// - `neighbours`: n_triangles x n_triangles, nearby triangles
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::{linalg::Csr, loss::{OverlapSettings, overlaps}};
/// let square = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
/// let both = Csr::from_edges(2, [[0, 1]]);
/// let settings = OverlapSettings { per_triangle: 10, flatness: 0.1 };
/// assert_eq!(overlaps(&square, &[[0, 1, 2], [0, 1, 3]], &both, settings), [[0, 1], [1, 0]]);
/// assert!(overlaps(&square, &[[0, 1, 2], [0, 2, 3]], &both, settings).is_empty());
/// ```
pub fn overlaps(
    points: &[[f32; 3]],
    triangles: &[[u32; 3]],
    neighbours: &Csr,
    settings: OverlapSettings,
) -> Vec<[u32; 2]> {
    near_pairs(neighbours, |t, u| {
        let [t, u] = [t, u].map(|t| corners_f64(points, triangles[t as usize]));
        are_parallel(t, u) && spread_points(t, settings.per_triangle).any(|y| is_over(to_f64(y), u, settings.flatness))
    })
}

/// Relative excess of the three summed areas that counts as rounding.
const ROUNDING: f64 = 1e-6;

/// Smallest absolute cosine between the normals of nearly parallel triangles.
const PARALLEL: f64 = 0.9;

fn are_parallel(t: [DVec3; 3], u: [DVec3; 3]) -> bool {
    let [t, u] = [t, u].map(|corners| area_normal_f64(corners).normalize_or_zero());
    t.dot(u).abs() >= PARALLEL
}

fn is_over(y: DVec3, [a, b, c]: [DVec3; 3], flatness: f64) -> bool {
    let normal = area_normal_f64([a, b, c]);
    let area = normal.length();
    let Some(direction) = normal.try_normalize() else { return false };
    let height = (y - a).dot(direction);
    if height * height > flatness * flatness * area / 2.0 {
        return false;
    }
    let foot = y - direction * height;
    let parts = [[foot, a, b], [foot, b, c], [foot, c, a]].map(|part| area_normal_f64(part).length());
    parts.iter().sum::<f64>() <= area * (1.0 + ROUNDING)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SETTINGS: OverlapSettings = OverlapSettings { per_triangle: 16, flatness: 0.1 };

    fn pairs(points: &[[f32; 3]], other: [u32; 3]) -> Vec<[u32; 2]> {
        overlaps(points, &[[0, 1, 2], other], &Csr::from_edges(2, [[0, 1]]), SETTINGS)
    }

    #[test]
    fn over_is_inside_and_near() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let over = |x: f64, y: f64, z: f64| is_over(DVec3::new(x, y, z), corners, 0.1);
        assert!(over(0.25, 0.25, 0.0) && over(0.25, 0.25, 0.07) && over(0.5, 0.5, 0.0));
        assert!(!over(0.25, 0.25, 0.08), "0.1 of the square root of a half is 0.0707");
        assert!(!over(0.51, 0.51, 0.0) && !over(-0.01, 0.2, 0.0));
    }

    #[test]
    fn neighbours_overlap_only_where_they_are_folded_onto_each_other() {
        let turn_corner = |angle: f32| [0.5, angle.to_radians().cos(), angle.to_radians().sin()];
        let folded =
            |angle: f32| pairs(&[[0.0; 3], [1.0, 0.0, 0.0], turn_corner(0.0), turn_corner(angle)], [0, 1, 3]).len();
        assert_eq!([180.0, 120.0, 90.0, 60.0].map(folded), [0; 4]);
        assert_eq!([3.0, 0.0].map(folded), [2; 2]);
    }

    #[test]
    fn a_small_triangle_over_a_large_one_is_found_from_one_side_at_least() {
        let points = [[0.0; 3], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0], [2.0, 2.0, 0.01], [2.1, 2.0, 0.01], [2.0, 2.1, 0.01]];
        assert!(pairs(&points, [3, 4, 5]).contains(&[1, 0]));
    }

    #[test]
    fn triangles_without_area_take_no_part() {
        let line = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.0, 0.0]];
        assert!(pairs(&line, [0, 1, 3]).is_empty());
        assert!(!is_over(DVec3::ZERO, [DVec3::ZERO; 3], 0.1));
        assert!(overlaps(&[], &[], &Csr::from_edges(0, []), SETTINGS).is_empty());
    }
}
