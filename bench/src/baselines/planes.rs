//! Positions in double precision and quadrics of faces.

use glam::DVec3;

use neural_mesh::geometry::Quadric;
use neural_mesh::geometry::triangle::area_normal_f64;

pub(super) fn to_double(rows: &[[f32; 3]]) -> Vec<DVec3> {
    rows.iter().map(|row| DVec3::from_array(row.map(f64::from))).collect()
}

pub(super) fn face_plane(corners: [DVec3; 3]) -> Quadric {
    let normal = area_normal_f64(corners);
    Quadric::from_plane(normal.normalize_or_zero(), corners[0], 0.5 * normal.length())
}
