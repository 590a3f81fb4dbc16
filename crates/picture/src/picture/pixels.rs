//! Limits of image decoders, and conversions of pixels.

use glam::Vec3;

use crate::mesh::{linear_light, srgb};

/// Largest number of pixels of a decoded image; larger ones are halved while they are read.
pub(super) const MOST_PIXELS: usize = 1 << 26;
/// Largest number of pixels that are read at all, and those of each byte of the file above [`MOST_PIXELS`]. The best
/// compressed plain images of PNG and JPEG have less than 400 a byte.
const MOST_READ: (usize, usize) = (1 << 30, 1024);

pub(super) fn add_opacity(rgb: &[u8]) -> Vec<u8> {
    rgb.as_chunks::<3>().0.iter().flat_map(|&[r, g, b]| [r, g, b, 255]).collect()
}

/// Returns the number of pixels; `None` if zero, or too large for a file of `n_bytes`.
pub(super) fn check_size(width: usize, height: usize, n_bytes: usize) -> Option<usize> {
    let most = MOST_READ.1.saturating_mul(n_bytes).clamp(MOST_PIXELS, MOST_READ.0);
    width.checked_mul(height).filter(|n| (1..=most).contains(n))
}

pub(super) fn from_srgb(colour: [u8; 3]) -> Vec3 {
    Vec3::from(colour.map(|byte| linear_light(f32::from(byte) / 255.0)))
}

pub(super) fn to_srgb(linear: Vec3) -> [u8; 4] {
    let encode = |x: f32| (srgb(x.clamp(0.0, 1.0)) * 255.0).round() as u8;
    [encode(linear.x), encode(linear.y), encode(linear.z), 255]
}
