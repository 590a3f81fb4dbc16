//! Limits and conversions common to the image decoders.

const MOST_PIXELS: usize = 1 << 26;

pub(super) fn add_opacity(rgb: &[u8]) -> Vec<u8> {
    rgb.as_chunks::<3>().0.iter().flat_map(|&[r, g, b]| [r, g, b, 255]).collect()
}

/// Returns the number of pixels; `None` if zero or too large.
pub(super) fn check_size(width: usize, height: usize) -> Option<usize> {
    width.checked_mul(height).filter(|n| (1..=MOST_PIXELS).contains(n))
}
