//! Exact intersection tests of two triangles.

use glam::DVec3;
use robust::{Coord, Coord3D, orient2d, orient3d};

/// Largest error of a height over the sum of the absolute products in it; eleven roundings of 2^-53 are an eighth of it.
const ROUNDING: f64 = 1e-14;

/// Returns whether two triangles intersect beyond their boundaries or overlap in a plane.
///
/// Exact (Shewchuk 1997). Touching is no intersection, nor are common vertices and edges. A triangle without area
/// intersects nothing.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::geometry::crossing::triangles_cross;
/// let flat = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
/// let upright = |z: f32| [[0.5, 0.5, z], [0.6, 0.5, z + 1.0], [0.7, 0.5, z + 1.0]];
/// assert!(triangles_cross(flat, upright(-0.5)));
/// assert!(!triangles_cross(flat, upright(0.0)));
/// ```
pub fn triangles_cross(a: [[f32; 3]; 3], b: [[f32; 3]; 3]) -> bool {
    let sides_of_b = sides(b, a);
    if are_on_one_side(sides_of_b) {
        return sides_of_b == [0; 3] && overlap_in_plane(a, b);
    }
    let sides_of_a = sides(a, b);
    if are_on_one_side(sides_of_a) {
        return false;
    }
    has_passing_edge(a, sides_of_b, b) || has_passing_edge(b, sides_of_a, a)
}

/// Returns whether an edge of `a` passes through the inside of `b`.
///
/// Exact, as [`triangles_cross`].
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::geometry::crossing::edge_passes_through;
/// let flat = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
/// let upright = [[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [9.0, 9.0, 1.0]];
/// assert!(edge_passes_through(upright, flat) && edge_passes_through(flat, upright));
/// let small = [[1.0, 1.0, -1.0], [1.0, 1.1, 1.0], [1.1, 1.0, 1.0]];
/// assert!(edge_passes_through(small, flat) && !edge_passes_through(flat, small));
/// ```
pub fn edge_passes_through(a: [[f32; 3]; 3], b: [[f32; 3]; 3]) -> bool {
    let sides_of_b = sides(b, a);
    // Otherwise a only touches b, or has no area.
    let a_is_crossed = || !are_on_one_side(sides(a, b));
    !are_on_one_side(sides_of_b) && has_passing_edge(a, sides_of_b, b) && a_is_crossed()
}

fn are_on_one_side([a, b, c]: [i8; 3]) -> bool {
    (a >= 0) & (b >= 0) & (c >= 0) || (a <= 0) & (b <= 0) & (c <= 0)
}

/// Returns whether an edge of `a` passes through `b` elsewhere than at a corner.
fn has_passing_edge(a: [[f32; 3]; 3], sides: [i8; 3], b: [[f32; 3]; 3]) -> bool {
    [(0, 1), (1, 2), (2, 0)].into_iter().any(|(i, j)| {
        sides[i] * sides[j] < 0 && {
            let around = [(0, 1), (1, 2), (2, 0)].map(|(k, l)| side([a[i], b[k], b[l]], a[j]));
            are_on_one_side(around) && around.iter().filter(|&&s| s == 0).count() < 2
        }
    })
}

fn overlap_in_plane(a: [[f32; 3]; 3], b: [[f32; 3]; 3]) -> bool {
    let Some(dropped) = (0..3).find(|&axis| turn(a, axis) != 0 && turn(b, axis) != 0) else { return false };
    let keeps_apart = |a: [[f32; 3]; 3], b: [[f32; 3]; 3]| {
        let inward = turn(a, dropped);
        [(0, 1), (1, 2), (2, 0)]
            .into_iter()
            .any(|(i, j)| b.iter().all(|&p| turn([a[i], a[j], p], dropped) * inward <= 0))
    };
    !keeps_apart(a, b) && !keeps_apart(b, a)
}

/// The side of each point as [`side`], with one normal for all where rounding leaves no doubt.
#[inline(always)]
fn sides(triangle: [[f32; 3]; 3], [p, q, r]: [[f32; 3]; 3]) -> [i8; 3] {
    let wide = |[x, y, z]: [f32; 3]| DVec3::new(f64::from(x), f64::from(y), f64::from(z));
    let origin = wide(triangle[0]);
    let (u, v) = (wide(triangle[1]) - origin, wide(triangle[2]) - origin);
    let normal = u.cross(v);
    let (u, v) = (u.abs(), v.abs());
    let largest = ROUNDING * DVec3::new(u.y * v.z + u.z * v.y, u.z * v.x + u.x * v.z, u.x * v.y + u.y * v.x);
    let side = |p: [f32; 3]| {
        let along = wide(p) - origin;
        let height = normal.dot(along);
        if height.abs() > largest.dot(along.abs()) { sign(-height) } else { side(triangle, p) }
    };
    [side(p), side(q), side(r)]
}

fn side(triangle: [[f32; 3]; 3], p: [f32; 3]) -> i8 {
    // Neighbours share corners, and the exact test of a zero is the slowest.
    if triangle.contains(&p) {
        return 0;
    }
    let coord = |[x, y, z]: [f32; 3]| Coord3D { x, y, z };
    let [a, b, c] = triangle;
    sign(orient3d(coord(a), coord(b), coord(c), coord(p)))
}

fn turn(points: [[f32; 3]; 3], axis: usize) -> i8 {
    let [a, b, c] = points.map(|p| Coord { x: p[(axis + 1) % 3], y: p[(axis + 2) % 3] });
    sign(orient2d(a, b, c))
}

fn sign(x: f64) -> i8 {
    i8::from(x > 0.0) - i8::from(x < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLAT: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];

    fn cross(a: [[f32; 3]; 3], b: [[f32; 3]; 3]) -> bool {
        let orders = |[x, y, z]: [[f32; 3]; 3]| [[x, y, z], [y, z, x], [z, x, y], [x, z, y], [z, y, x], [y, x, z]];
        let mut answers = Vec::new();
        for (a, b) in orders(a).into_iter().flat_map(|a| orders(b).map(|b| (a, b))) {
            answers.extend([triangles_cross(a, b), triangles_cross(b, a)]);
        }
        assert!(answers.iter().all(|&answer| answer == answers[0]), "{answers:?}");
        answers[0]
    }

    #[test]
    fn passing_through_is_crossing() {
        assert!(cross(FLAT, [[0.5, 0.5, -1.0], [0.6, 0.5, 1.0], [0.5, 0.6, 1.0]]));
        assert!(cross(FLAT, [[0.5, 0.5, -1.0], [0.5, 0.5, 1.0], [9.0, 9.0, 1.0]]));
        assert!(!cross(FLAT, [[1.5, 1.5, -1.0], [1.6, 1.5, 1.0], [1.5, 1.6, 1.0]]));
    }

    #[test]
    fn neighbours_that_only_share_corners_do_not_cross() {
        let [a, b, c] = FLAT;
        assert!(!cross(FLAT, [a, b, [0.0, 0.0, 1.0]]));
        assert!(!cross(FLAT, [b, c, [3.0, 3.0, 0.0]]));
        assert!(!cross(FLAT, [a, [-1.0, 0.0, 1.0], [0.0, -1.0, 1.0]]));
    }

    #[test]
    fn neighbours_that_share_a_corner_and_pass_through_cross() {
        assert!(cross(FLAT, [FLAT[0], [1.0, 0.5, -1.0], [0.5, 1.0, 1.0]]));
    }

    #[test]
    fn edges_pass_through_where_triangles_cross_outside_of_one_plane() {
        let [a, b, c] = FLAT;
        let others = [
            [[0.5, 0.5, -1.0], [0.6, 0.5, 1.0], [0.5, 0.6, 1.0]],
            [[0.5, 0.5, -1.0], [0.5, 0.5, 1.0], [9.0, 9.0, 1.0]],
            [a, b, [0.0, 0.0, 1.0]],
            [a, [1.0, 0.5, -1.0], [0.5, 1.0, 1.0]],
            [a, [-1.0, 0.0, 1.0], [0.0, -1.0, 1.0]],
            [[0.5, 0.5, 0.0], [1.0, 0.5, 1.0], [0.5, 1.0, 1.0]],
            [[0.5, 0.5, -1.0], [0.5, 0.5, 0.5], [0.5, 0.5, 1.0]],
            [b, c, [3.0, 3.0, -2.0]],
        ];
        for other in others {
            let passes = edge_passes_through(FLAT, other) || edge_passes_through(other, FLAT);
            assert_eq!(passes, triangles_cross(FLAT, other), "{other:?}");
        }
        assert!(!edge_passes_through(FLAT, FLAT));
    }

    #[test]
    fn overlap_in_a_plane_is_crossing_and_contact_is_not() {
        let [a, b, c] = FLAT;
        assert!(cross(FLAT, FLAT));
        assert!(cross(FLAT, [a, b, [0.1, 1.0, 0.0]]));
        assert!(cross(FLAT, [[0.2, 0.2, 0.0], [0.3, 0.2, 0.0], [0.2, 0.3, 0.0]]));
        assert!(!cross(FLAT, [c, b, [1.5, 1.5, 0.0]]));
        assert!(!cross(FLAT, [[0.5, 0.0, 0.0], [1.5, 0.0, 0.0], [1.0, -1.0, 0.0]]));
        assert!(!cross(FLAT, [[0.5, 0.5, 0.0], [1.0, 0.5, 1.0], [0.5, 1.0, 1.0]]));
    }

    #[test]
    fn sides_of_three_points_are_those_of_each() {
        // Small integers put many points in the plane, a shift makes the differences round.
        let mut state = 1u64;
        let mut draw = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as u32
        };
        for i in 0..20_000 {
            let shift = [0.0, 0.1, 1e6, 1e-30][i % 4];
            let mut point = || [(); 3].map(|()| (draw() % 5) as f32 * if i % 3 == 0 { 0.1 } else { 1.0 } + shift);
            let (triangle, points) = ([(); 3].map(|()| point()), [(); 3].map(|()| point()));
            assert_eq!(sides(triangle, points), points.map(|p| side(triangle, p)), "{triangle:?} {points:?}");
        }
    }

    #[test]
    fn triangles_without_area_cross_nothing() {
        assert!(!cross(FLAT, [[0.5, 0.5, -1.0], [0.5, 0.5, 0.5], [0.5, 0.5, 1.0]]));
        assert!(!cross(FLAT, [[0.5, 0.5, 0.0]; 3]));
    }
}
