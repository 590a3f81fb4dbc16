//! Measures of one triangle.

use glam::{DVec3, Vec3};

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

/// Returns the [`area_normal`] in double precision.
pub fn area_normal_f64([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// Returns barycentric weights of the point of triangle `a b c` closest to `p`.
///
/// After Ericson, "Real-Time Collision Detection", Sec. 5.1.5; imprecise for a triangle without area.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::geometry::triangle::nearest_weights;
/// let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Into::into);
/// assert_eq!(nearest_weights([2.0, -1.0, 5.0].into(), corners), [0.0, 1.0, 0.0]);
/// ```
pub fn nearest_weights(p: Vec3, [a, b, c]: [Vec3; 3]) -> [f32; 3] {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = ratio(d1, d1 - d3);
        return [1.0 - t, t, 0.0];
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = ratio(d2, d2 - d6);
        return [1.0 - t, 0.0, t];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let t = ratio(d4 - d3, (d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - t, t];
    }
    let (v, w) = (vb / (va + vb + vc), vc / (va + vb + vc));
    [1.0 - v - w, v, w]
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
