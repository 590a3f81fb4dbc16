//! Numbers of the format.

use glam::Vec3;

use crate::spatial::Bounds;

pub fn center_and_half(bounds: &Bounds) -> (Vec3, Vec3) {
    let [low, high] = [bounds.low, bounds.high].map(Vec3::from);
    (0.5 * low + 0.5 * high, 0.5 * high - 0.5 * low)
}
