//! Bounding boxes in double precision.

use glam::DVec3;

/// Returns the low and high corner of the points' bounding box, infinite and inverted without points.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use glam::DVec3;
/// let (low, high) = neural_mesh::geometry::extent([DVec3::X, 2.0 * DVec3::Y]);
/// assert_eq!((low, high), (DVec3::ZERO, DVec3::new(1.0, 2.0, 0.0)));
/// ```
pub fn extent(points: impl IntoIterator<Item = DVec3>) -> (DVec3, DVec3) {
    let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    points.into_iter().fold(empty, |(low, high), point| (low.min(point), high.max(point)))
}
