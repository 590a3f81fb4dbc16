//! Faces over a triangle, seen along its normal or another direction.
//!
//! They are found from neighbour to neighbour. If all face as the triangle does, and no boundary lies inside it, they
//! cover it, since their outline winds around it. The height is linear over each face, so it is largest at a corner of the
//! face's part over the triangle.

use glam::{DVec3, DVec4, Vec4Swizzles};

/// Weight below which a point counts as outside a triangle, so that common edges are no boundary inside.
const INSET: f64 = 1e-9;
/// Volume spanned by the weights of a face's corners, over the largest possible, below which it is lost in rounding.
const LEAST_VOLUME: f64 = 1e-4;
/// Most corners of a triangle cut by three lines, also where rounding has bent it.
const MOST_CORNERS: usize = 9;

/// Coordinates of points seen along a direction: three barycentric weights in a triangle and the height over its plane.
pub struct Footprint {
    origin: DVec3,
    columns: [DVec4; 3],
    /// Unit vector.
    pub direction: DVec3,
    longest_side: f64,
}

impl Footprint {
    /// Returns `None` for a triangle without area as seen from this side.
    pub fn new([a, b, c]: [DVec3; 3], direction: DVec3) -> Option<Self> {
        let area2 = (b - a).cross(c - a).dot(direction);
        if area2 <= 0.0 {
            return None;
        }
        let gradients = [c - b, a - c, b - a].map(|side| direction.cross(side) / area2);
        // The plane may be oblique: at corners it is as high as they are.
        let height = direction - gradients[1] * direction.dot(b - a) - gradients[2] * direction.dot(c - a);
        let column = |component: fn(DVec3) -> f64| {
            let [u, v, w] = gradients.map(component);
            DVec4::new(u, v, w, component(height))
        };
        let columns = [column(|v| v.x), column(|v| v.y), column(|v| v.z)];
        let longest2 = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
        Some(Self { origin: a, columns, direction, longest_side: longest2.sqrt() })
    }

    pub fn coordinates(&self, p: DVec3) -> DVec4 {
        let ([x, y, z], [of_x, of_y, of_z]) = ((p - self.origin).to_array(), self.columns);
        DVec4::X + x * of_x + y * of_y + z * of_z
    }

    /// Returns a bound of the heights of a face's part over the triangle, which is sharp above `enough`.
    pub fn height(&self, corners: &[DVec4; 3], enough: f64) -> f64 {
        // Both of the face and of the triangle, the part is a subset.
        let of_face = corners.iter().fold(0.0, |most: f64, p| most.max(p.w.abs()));
        let height = if of_face <= enough { of_face } else { of_face.min(largest_height_at_corners(corners)) };
        let height = if height <= enough { height } else { largest_height_inside(corners) };
        // The rim of width INSET may be open.
        height + 2.0 * INSET * self.longest_side
    }
}

/// Returns the largest height of a face's plane over the corners of the triangle.
fn largest_height_at_corners([a, b, c]: &[DVec4; 3]) -> f64 {
    // The rows of the inverse of the corners' weights tell the triangle's corners as weights of the face's.
    let (bc, ca, ab) = (b.xyz().cross(c.xyz()), c.xyz().cross(a.xyz()), a.xyz().cross(b.xyz()));
    let volume = a.xyz().dot(bc);
    if volume <= LEAST_VOLUME * (a.xyz().length_squared() * bc.length_squared()).sqrt() {
        return f64::INFINITY;
    }
    ((a.w * bc + b.w * ca + c.w * ab) / volume).abs().max_element()
}

/// Returns whether a side of a face may pass through the inside of the triangle; the face lies on the side's left.
pub fn passes_inside(a: DVec4, b: DVec4) -> bool {
    let is_beside = a.xyz().cmple(DVec3::splat(INSET)) & b.xyz().cmple(DVec3::splat(INSET));
    // The weights' cross product tells on which side of the line each corner of the triangle is.
    !is_beside.any() && a.xyz().cross(b.xyz()).cmplt(DVec3::ZERO).any()
}

/// Returns the largest height of a face's part over the triangle.
fn largest_height_inside(corners: &[DVec4; 3]) -> f64 {
    let mut polygon = [DVec4::ZERO; MOST_CORNERS];
    polygon[..3].copy_from_slice(corners);
    let mut n = 3;
    for axis in 0..3 {
        let (before, n_before) = (polygon, n);
        n = 0;
        let mut add = |p: DVec4| {
            polygon[n] = p;
            n += 1;
        };
        for i in 0..n_before {
            let (p, q) = (before[i], before[(i + 1) % n_before]);
            if p[axis] >= 0.0 {
                add(p);
            }
            if p[axis] * q[axis] < 0.0 {
                add(p.lerp(q, p[axis] / (p[axis] - q[axis])));
            }
        }
    }
    polygon[..n].iter().fold(0.0, |most, p| most.max(p.w.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn footprint() -> Footprint {
        let corners = [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]].map(DVec3::from);
        Footprint::new(corners, DVec3::Z).unwrap()
    }

    #[test]
    pub fn coordinates_are_weights_and_height() {
        let coordinates = |p: [f64; 3]| footprint().coordinates(DVec3::from(p)).to_array();
        assert_eq!(coordinates([0.0, 0.0, 3.0]), [1.0, 0.0, 0.0, 3.0]);
        assert_eq!(coordinates([1.0, 1.0, -2.0]), [0.0, 0.5, 0.5, -2.0]);
        assert_eq!(coordinates([2.0, 2.0, 0.0]), [-1.0, 1.0, 1.0, 0.0]);
        assert!(Footprint::new([DVec3::ZERO, DVec3::X, 2.0 * DVec3::X], DVec3::ZERO).is_none());
    }

    #[test]
    fn heights_along_another_direction_are_those_over_the_triangle() {
        let corners = [[0.0, 0.0, 0.0], [2.0, 0.0, 1.0], [0.0, 2.0, -3.0]].map(DVec3::from);
        let oblique = Footprint::new(corners, DVec3::Z).unwrap();
        for (corner, weights) in corners.into_iter().zip([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]) {
            let seen = oblique.coordinates(corner + 5.0 * DVec3::Z);
            assert!(seen.abs_diff_eq(DVec3::from(weights).extend(5.0), 1e-12), "{seen}");
        }
    }

    #[test]
    fn heights_beyond_the_triangle_do_not_count() {
        // A face that rises along x, of which the part with x < 2 lies over the triangle.
        let face = [[-1.0, -1.0, -1.0], [9.0, -1.0, 9.0], [-1.0, 9.0, -1.0]];
        let height = footprint().height(&face.map(|p| footprint().coordinates(DVec3::from(p))), 0.0);
        assert!((height - 2.0).abs() < 1e-6, "{height}");
    }

    #[test]
    fn sides_along_the_triangle_do_not_pass_inside() {
        let passes = |a: [f64; 3], b: [f64; 3]| {
            let [a, b] = [a, b].map(|p| footprint().coordinates(DVec3::from(p)));
            passes_inside(a, b)
        };
        assert!(!passes([0.0; 3], [2.0, 0.0, 0.0]) && !passes([0.0, 2.0, 0.0], [0.0; 3]));
        assert!(passes([-1.0, 1.0, 0.0], [3.0, 1.0, 0.0]) && passes([3.0, 0.5, 0.0], [-1.0, 0.5, 1.0]));
        // Next to the triangle, and past its corner with the triangle on the face's side.
        assert!(!passes([-1.0, -1.0, 0.0], [3.0, -1.0, 0.0]) && !passes([3.0, 0.0, 0.0], [0.0, 3.0, 0.0]));
    }
}
