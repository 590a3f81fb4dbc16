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
    encode(image, png::ColorType::Rgba, &image.rgba).unwrap_or_default()
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
    encode(image, png::ColorType::Rgb, image.colours().as_flattened()).unwrap_or_default()
}

fn encode(image: &Image, kind: png::ColorType, pixels: &[u8]) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let [width, height] = [image.width, image.height].map(|side| u32::try_from(side).unwrap_or(0));
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(kind);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels)?;
    writer.finish()?;
    Ok(bytes)
}
