//! Points in double precision.

use glam::DVec3;

pub(super) fn to_double(rows: &[[f32; 3]]) -> Vec<DVec3> {
    rows.iter().map(|row| DVec3::from_array(row.map(f64::from))).collect()
}
