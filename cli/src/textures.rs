//! `--textures`: images made smaller on their way into files.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use fast_image_resize::images::Image as Pixels;
use fast_image_resize::{
    FilterType, ImageBufferError, PixelType, ResizeAlg, ResizeOptions, Resizer, create_srgb_mapper,
};
use jpeg_encoder::{ColorType, Encoder};
use neural_mesh::io::{Format, ImageMaker, ImageUse};
use neural_mesh::picture::{Image, ImageFormat, decode_image, encode_png, encode_png_opaque, encode_webp, image_size};

use crate::failure::Failure;

/// Of 100, for JPEG.
const QUALITY: u8 = 90;

/// Refuses formats that name no textures.
pub fn check(output: Format) -> Result<(), Failure> {
    match output {
        Format::Glb | Format::Gltf | Format::Obj | Format::Ply | Format::PlyAscii => Ok(()),
        other => {
            let what = format!("--textures: {} holds no textures: write glb, gltf, obj or ply", other.name());
            Err(Failure::Usage(what))
        }
    }
}

/// What became of images, by hashes of their bytes and their uses; nothing of those that stay.
type Made = HashMap<(u64, ImageUse), Option<Vec<u8>>>;

/// Makes images smaller that are longer than `side` pixels; the others keep every byte.
#[derive(Debug)]
pub struct Textures {
    side: usize,
    /// What was made, by what of, so that several results share it.
    made: Mutex<Made>,
    has_unread: AtomicBool,
}

impl Textures {
    /// Images of at most `side` pixels a side.
    pub fn new(side: usize) -> Self {
        Self { side, made: Mutex::default(), has_unread: AtomicBool::new(false) }
    }

    /// What could not be made smaller.
    pub fn note(&self) -> Option<String> {
        let what = "images that are no readable PNG, JPEG or WebP keep their size";
        self.has_unread.load(Ordering::Relaxed).then(|| what.into())
    }
}

impl ImageMaker for Textures {
    fn made(&self, image: &[u8], used: ImageUse) -> Option<Vec<u8>> {
        let mut hasher = DefaultHasher::new();
        image.hash(&mut hasher);
        let key = (hasher.finish(), used);
        if let Some(known) = self.made.lock().ok().and_then(|made| made.get(&key).cloned()) {
            return known;
        }
        let made = match image_size(image) {
            Some([width, height]) if width.max(height) <= self.side => None,
            size => {
                let smaller = size.and_then(|_| smaller(image, used, self.side));
                self.has_unread.fetch_or(smaller.is_none(), Ordering::Relaxed);
                smaller
            }
        };
        if let Ok(mut known) = self.made.lock() {
            known.insert(key, made.clone());
        }
        made
    }
}

/// The file of an image as a file of the same format whose longer side has `side` pixels; `None` where it cannot be read.
fn smaller(file: &[u8], used: ImageUse, side: usize) -> Option<Vec<u8>> {
    let image = decode_image(file)?;
    let longer = image.width.max(image.height);
    let scaled = |length: usize| ((length * side + longer / 2) / longer).max(1);
    let size = [scaled(image.width), scaled(image.height)];
    let smaller = resized(image, size, used).ok()?;
    match ImageFormat::of(file)? {
        ImageFormat::Png => {}
        ImageFormat::WebP => return encode_webp(&smaller),
        _ => return jpeg(&smaller),
    }
    let is_opaque = smaller.rgba.as_chunks::<4>().0.iter().all(|pixel| pixel[3] == u8::MAX);
    Some(if is_opaque { encode_png_opaque(&smaller) } else { encode_png(&smaller) })
}

/// An image in another size: colours by their light, as far as they are opaque; numbers by their means; directions of length 1.
fn resized(image: Image, size: [usize; 2], used: ImageUse) -> Result<Image, ImageBufferError> {
    let bytes = |[width, height]: [usize; 2], kind| Pixels::new(width as u32, height as u32, kind);
    let Image { width, height, rgba } = image;
    let whole = Pixels::from_vec_u8(width as u32, height as u32, rgba, PixelType::U8x4)?;
    let mut small = bytes(size, PixelType::U8x4);
    // The calls below fail for sizes and kinds of pixels that differ alone, which are given here.
    if used == ImageUse::Colours {
        let (mut light, mut small_light) = (bytes([width, height], PixelType::U16x4), bytes(size, PixelType::U16x4));
        let srgb = create_srgb_mapper();
        let sharp = ResizeOptions::new().resize_alg(ResizeAlg::Convolution(FilterType::Lanczos3));
        let _ = srgb.forward_map(&whole, &mut light);
        let _ = Resizer::new().resize(&light, &mut small_light, &sharp);
        let _ = srgb.backward_map(&small_light, &mut small);
    } else {
        let mean = ResizeOptions::new().resize_alg(ResizeAlg::Convolution(FilterType::Box)).use_alpha(false);
        let _ = Resizer::new().resize(&whole, &mut small, &mean);
    }
    let mut rgba = small.into_vec();
    if used == ImageUse::Normals {
        rgba.as_chunks_mut::<4>().0.iter_mut().for_each(normalise);
    }
    Ok(Image { width: size[0], height: size[1], rgba })
}

/// Makes a direction one of length 1; opacity stays.
fn normalise(pixel: &mut [u8; 4]) {
    let direction: [f32; 3] = std::array::from_fn(|axis| f32::from(pixel[axis]) / 127.5 - 1.0);
    let length = direction.iter().map(|x| x * x).sum::<f32>().sqrt();
    if length > 0.1 {
        (0..3).for_each(|axis| pixel[axis] = ((direction[axis] / length + 1.0) * 127.5).round() as u8);
    }
}

fn jpeg(image: &Image) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    let [width, height] = [u16::try_from(image.width).ok()?, u16::try_from(image.height).ok()?];
    Encoder::new(&mut bytes, QUALITY).encode(&image.rgba, width, height, ColorType::Rgba).ok()?;
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: usize, height: usize, pixel: impl Fn(usize) -> [u8; 4]) -> Image {
        Image { width, height, rgba: (0..width * height).flat_map(pixel).collect() }
    }

    fn made(image: &Image, used: ImageUse, side: usize) -> Option<Image> {
        Textures::new(side).made(&encode_png(image), used).map(|file| decode_image(&file).unwrap())
    }

    #[test]
    fn the_longer_side_is_as_long_as_asked_and_small_images_keep_every_byte() {
        let long = image(60, 7, |_| [9, 90, 200, 255]);
        let small = made(&long, ImageUse::Colours, 30).unwrap();
        assert_eq!((small.width, small.height), (30, 4));
        assert!(small.rgba.as_chunks::<4>().0.iter().all(|pixel| *pixel == [9, 90, 200, 255]), "{:?}", small.rgba);
        let side = |pixels| made(&image(pixels, 1, |_| [1; 4]), ImageUse::Numbers, 8).map(|small| small.width);
        assert_eq!([side(8), side(9)], [None, Some(8)]);
    }

    #[test]
    fn light_is_averaged_for_colours_and_numbers_for_numbers() {
        let stripes = image(64, 64, |at| if at % 2 == 0 { [0, 0, 0, 255] } else { [255; 4] });
        let grey = |used| made(&stripes, used, 32).unwrap().rgba[4 * (16 * 32 + 16)];
        assert!((186..=190).contains(&grey(ImageUse::Colours)), "{}", grey(ImageUse::Colours));
        assert!((127..=128).contains(&grey(ImageUse::Numbers)), "{}", grey(ImageUse::Numbers));
    }

    #[test]
    fn what_is_not_seen_has_no_colour_to_give() {
        let cut_out = image(64, 64, |at| if at % 64 < 32 { [200, 0, 0, 255] } else { [0, 255, 0, 0] });
        let small = made(&cut_out, ImageUse::Colours, 16).unwrap();
        let seen = small.rgba.as_chunks::<4>().0.iter().filter(|pixel| pixel[3] > 0);
        assert!(
            seen.clone().count() >= 8 * 16 && seen.clone().all(|pixel| pixel[1] < 8),
            "{:?}",
            seen.collect::<Vec<_>>()
        );
    }

    #[test]
    fn directions_keep_their_length() {
        let bumps = image(64, 1, |at| if at % 2 == 0 { [218, 128, 218, 255] } else { [37, 128, 218, 255] });
        let small = made(&bumps, ImageUse::Normals, 32).unwrap();
        assert!(small.rgba.as_chunks::<4>().0.iter().all(|pixel| pixel[2] >= 254), "{:?}", small.rgba);
    }

    #[test]
    fn a_jpeg_and_a_webp_stay_such_and_what_is_neither_is_said() {
        let file = jpeg(&image(64, 32, |_| [40, 80, 120, 255])).unwrap();
        let textures = Textures::new(16);
        let webp = encode_webp(&image(64, 32, |_| [40, 80, 120, 9])).unwrap();
        let small = textures.made(&webp, ImageUse::Numbers).unwrap();
        assert_eq!((ImageFormat::of(&small), image_size(&small)), (Some(ImageFormat::WebP), Some([16, 8])));
        let small = textures.made(&file, ImageUse::Colours).unwrap();
        assert!(small.starts_with(b"\xff\xd8") && image_size(&small) == Some([16, 8]));
        assert_eq!(textures.note(), None);
        for other in [&b"RIFF0000WEBP"[..], b"", &file[..40]] {
            assert_eq!(textures.made(other, ImageUse::Colours), None);
        }
        assert!(textures.note().is_some());
    }
}
