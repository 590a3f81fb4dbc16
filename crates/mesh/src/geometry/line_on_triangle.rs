//! Lines and triangles.

use glam::DVec3;

/// Intersects the line through `from` along `direction` with the plane of a triangle.
///
/// Returns the weights of the second and third corner, and the signed distance in lengths of `direction`; not finite if
/// line and plane are parallel (Möller and Trumbore 1997, "Fast, minimum storage ray/triangle intersection").
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use glam::DVec3;
/// use neural_mesh::geometry::line_on_triangle::line_on_triangle;
/// let triangle = [DVec3::ZERO, DVec3::X, DVec3::Y];
/// let from = DVec3::new(0.25, 0.5, 3.0);
/// assert_eq!(line_on_triangle(from, -DVec3::Z, triangle), [0.25, 0.5, 3.0]);
/// assert_eq!(line_on_triangle(from, DVec3::Z, triangle), [0.25, 0.5, -3.0]);
/// assert!(line_on_triangle(from, DVec3::X, triangle).iter().any(|x| !x.is_finite()));
/// ```
#[inline]
pub fn line_on_triangle(from: DVec3, direction: DVec3, [a, b, c]: [DVec3; 3]) -> [f64; 3] {
    let (ab, ac) = (b - a, c - a);
    let across = direction.cross(ac);
    let slope = ab.dot(across);
    let to_line = from - a;
    let turned = to_line.cross(ab);
    [to_line.dot(across) / slope, direction.dot(turned) / slope, ac.dot(turned) / slope]
}
