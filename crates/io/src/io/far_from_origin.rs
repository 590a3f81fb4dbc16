//! Test for meshes far from the origin.

use glam::DVec3;

/// Returns whether a coordinate exceeds 16 times the bounding box's longest side.
pub(super) fn is_far_from_origin(positions: &[[f64; 3]]) -> bool {
    let points = || positions.iter().map(|&p| DVec3::from(p)).filter(|p| p.is_finite());
    let low = points().fold(DVec3::INFINITY, DVec3::min);
    let high = points().fold(DVec3::NEG_INFINITY, DVec3::max);
    low.abs().max(high.abs()).max_element() > 16.0 * (high - low).max_element()
}
