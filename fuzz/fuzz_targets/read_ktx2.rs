//! Arbitrary bytes as KTX2: nothing, or an image of the declared size.

#![no_main]

use neural_mesh::picture::{decode_image, image_size};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    // Larger images only take longer.
    if image_size(bytes).is_none_or(|[width, height]| width.saturating_mul(height) > 1 << 16) {
        return;
    }
    if let Some(image) = decode_image(bytes) {
        assert_eq!(image_size(bytes), Some([image.width, image.height]));
        assert_eq!(image.rgba.len(), 4 * image.width * image.height);
    }
});
