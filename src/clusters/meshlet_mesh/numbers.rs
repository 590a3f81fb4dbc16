//! Numbers of the format.

use glam::Vec3;

use crate::spatial::Bounds;

pub fn center_and_half(bounds: &Bounds) -> (Vec3, Vec3) {
    let [low, high] = [bounds.low, bounds.high].map(Vec3::from);
    (0.5 * low + 0.5 * high, 0.5 * high - 0.5 * low)
}

pub fn push_count(bytes: &mut Vec<u8>, count: usize) {
    bytes.extend((count as u64).to_le_bytes());
}

pub fn push_floats(bytes: &mut Vec<u8>, numbers: impl Iterator<Item = f32>) {
    numbers.for_each(|x| bytes.extend(x.to_le_bytes()));
}
