//! What the methods share: rows in double precision, and the plane of a face as a quadric.

use glam::DVec3;

use neural_mesh::geometry::Quadric;
use neural_mesh::geometry::triangle::area_normal_f64;

pub(super) fn in_double(rows: &[[f32; 3]]) -> Vec<DVec3> {
    rows.iter().map(|row| DVec3::from_array(row.map(f64::from))).collect()
}

/// The squared distance to the plane of a face, weighed by its area; nothing where it has none.
pub(super) fn face_plane(corners: [DVec3; 3]) -> Quadric {
    let normal = area_normal_f64(corners);
    Quadric::of_plane(normal.normalize_or_zero(), corners[0], 0.5 * normal.length())
}
