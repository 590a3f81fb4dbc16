//! What the decoders of all kinds of image files share: how many pixels an image may have, and colours without an opacity.

/// Pixels of an image at most: more would only fill the memory.
const MOST_PIXELS: usize = 1 << 26;

/// Colours with an opacity.
pub(super) fn opaque(rgb: &[u8]) -> Vec<u8> {
    rgb.as_chunks::<3>().0.iter().flat_map(|&[r, g, b]| [r, g, b, 255]).collect()
}

/// Refuses images without pixels or with too many.
pub(super) fn checked_size(width: usize, height: usize) -> Option<usize> {
    width.checked_mul(height).filter(|n| (1..=MOST_PIXELS).contains(n))
}
