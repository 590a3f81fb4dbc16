//! Measures of one triangle.

use std::ops::Div;

use glam::{DVec3, Vec3};

use super::nearest_on_triangle::nearest_weights_by;

/// Returns the normal of triangle `a b c` with twice the area as length.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::geometry::triangle::area_normal;
/// let n = area_normal([[0.0; 3], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Into::into));
/// assert_eq!(n.to_array(), [0.0, 0.0, 2.0]);
/// ```
pub fn area_normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    (b - a).cross(c - a)
}

/// Squared length of a normal, over the fourth power of an edge length, below which the area is rounding error.
const LEAST_AREA: f32 = 1e-12;

/// Returns whether the area normal of a triangle is more than rounding error.
#[inline]
#[doc(hidden)]
pub fn has_area(area_normal: Vec3, [a, b, c]: [Vec3; 3]) -> bool {
    let scale = a.distance_squared(b).max(a.distance_squared(c));
    area_normal.length_squared() > LEAST_AREA * scale * scale
}

/// Returns the unit normal of a triangle, zero if it has almost no area.
#[inline]
#[doc(hidden)]
pub fn unit_normal(corners: [Vec3; 3]) -> Vec3 {
    let normal = area_normal(corners);
    if has_area(normal, corners) { normal / normal.length() } else { Vec3::ZERO }
}

/// Converts corners to double precision.
#[inline(always)]
pub fn corners_f64([a, b, c]: [[f32; 3]; 3]) -> [DVec3; 3] {
    [Vec3::from(a).as_dvec3(), Vec3::from(b).as_dvec3(), Vec3::from(c).as_dvec3()]
}

/// Returns the [`area_normal`] in double precision.
pub fn area_normal_f64([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// Returns barycentric weights of the point of triangle `a b c` closest to `p`.
///
/// Imprecise for a triangle without area.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::geometry::triangle::nearest_weights;
/// let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Into::into);
/// assert_eq!(nearest_weights([2.0, -1.0, 5.0].into(), corners), [0.0, 1.0, 0.0]);
/// ```
pub fn nearest_weights(p: Vec3, corners: [Vec3; 3]) -> [f32; 3] {
    nearest_weights_by!(p, corners, ratio, f32::div)
}

fn ratio(part: f32, whole: f32) -> f32 {
    if whole > 0.0 { part / whole } else { 0.0 }
}

/// Returns the point of triangle `a b c` closest to `p`.
pub fn nearest_point(p: Vec3, corners: [Vec3; 3]) -> Vec3 {
    let [u, v, w] = nearest_weights(p, corners);
    corners[0] * u + corners[1] * v + corners[2] * w
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degenerate_triangles_have_weights_all_the_same() {
        let (a, b, c) = (Vec3::ZERO, Vec3::X, Vec3::new(0.5, 0.0, 0.0));
        for corners in [[a, b, b], [b, a, b], [b, b, a], [a, a, b], [b; 3], [a, b, c], [c, b, a]] {
            for p in [Vec3::new(0.25, 1.0, 0.0), Vec3::ZERO, Vec3::new(-3.0, 0.0, 2.0)] {
                let weights = nearest_weights(p, corners);
                assert!(weights.iter().all(|w| (0.0..=1.0).contains(w)), "{corners:?} {p} {weights:?}");
                assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-6);
            }
        }
    }
}
