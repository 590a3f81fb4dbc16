//! Writing of PNG files.

use super::Image;

/// Encodes an image as PNG, 8 bits per channel; empty if the number of pixels is zero or wrong.
///
/// ```
/// # use neural_mesh_picture as neural_mesh;
/// use neural_mesh::picture::{Image, encode_png};
/// let image = Image { width: 1, height: 1, rgba: vec![255; 4] };
/// assert!(encode_png(&image).starts_with(b"\x89PNG"));
/// ```
pub fn encode_png(image: &Image) -> Vec<u8> {
    let mut bytes = Vec::new();
    match encode(image, &mut bytes) {
        Ok(()) => bytes,
        Err(_) => Vec::new(),
    }
}

/// Encodes an image as [`encode_png`] does, without opacity.
///
/// ```
/// # use neural_mesh_picture as neural_mesh;
/// use neural_mesh::picture::{Image, decode_image, encode_png_opaque};
/// let image = Image { width: 1, height: 1, rgba: vec![7, 8, 9, 255] };
/// assert_eq!(decode_image(&encode_png_opaque(&image)), Some(image));
/// ```
pub fn encode_png_opaque(image: &Image) -> Vec<u8> {
    let mut bytes = Vec::new();
    let rgb: Vec<u8> = image.rgba.as_chunks::<4>().0.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect();
    let [width, height] = [image.width, image.height];
    match encode_as(png::ColorType::Rgb, width, height, &rgb, &mut bytes) {
        Ok(()) => bytes,
        Err(_) => Vec::new(),
    }
}

fn encode(image: &Image, bytes: &mut Vec<u8>) -> Result<(), png::EncodingError> {
    encode_as(png::ColorType::Rgba, image.width, image.height, &image.rgba, bytes)
}

fn encode_as(
    kind: png::ColorType,
    width: usize,
    height: usize,
    pixels: &[u8],
    bytes: &mut Vec<u8>,
) -> Result<(), png::EncodingError> {
    let [width, height] = [width, height].map(|side| u32::try_from(side).unwrap_or(0));
    let mut encoder = png::Encoder::new(bytes, width, height);
    encoder.set_color(kind);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels)?;
    writer.finish()
}
