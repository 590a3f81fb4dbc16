//! `--textures`: images reduced while files are written.

use std::collections::{BTreeSet, HashMap};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Mutex;

use crate::io::{ImageConverter, ImageUse};
use crate::mesh::{linear_light, srgb};
use crate::picture::{
    Image, ImageFormat, decode_image, decode_numbers, encode_jpeg, encode_png, encode_png_opaque, encode_webp,
    image_problem, image_size,
};
use resize::px::PixelFormat;
use resize::{Filter, Resizer, Type};

// Resized images by hash of bytes and use; `None` for unchanged ones.
type ResizedImages = HashMap<(u64, ImageUse), Option<Vec<u8>>>;

/// Resizer of images longer than `side` pixels; other images keep every byte.
#[derive(Debug)]
pub struct Textures {
    side: usize,
    // Resized images of all results are kept, so that no image is resized twice.
    made: Mutex<ResizedImages>,
    /// Reasons why images could not be resized.
    problems: Mutex<BTreeSet<String>>,
}

impl Textures {
    /// Creates a resizer for images of at most `side` pixels per side.
    pub fn new(side: usize) -> Self {
        Self { side, made: Mutex::default(), problems: Mutex::default() }
    }

    /// Returns a note about one image that could not be resized.
    pub fn note(&self) -> Option<String> {
        let problems = self.problems.lock().ok()?;
        problems.first().map(|problem| format!("an image keeps its size: it {problem}"))
    }
}

impl ImageConverter for Textures {
    fn convert(&self, image: &[u8], used: ImageUse) -> Option<Vec<u8>> {
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
                if smaller.is_none() {
                    self.problems.lock().ok().map(|mut problems| problems.insert(image_problem(image)));
                }
                smaller
            }
        };
        if let Ok(mut known) = self.made.lock() {
            known.insert(key, made.clone());
        }
        made
    }

    fn suffix(&self) -> Option<String> {
        Some(self.side.to_string())
    }
}

/// Resizes an image file in its format (PNG for KTX2); `None` if unreadable.
fn smaller(file: &[u8], used: ImageUse, side: usize) -> Option<Vec<u8>> {
    let image = if used == ImageUse::Colours { decode_image(file)? } else { decode_numbers(file)? };
    let longer = image.width.max(image.height);
    // A very large image may be halved below the requested side already.
    let side = side.min(longer);
    let scaled = |length: usize| ((length * side + longer / 2) / longer).max(1);
    let size = [scaled(image.width), scaled(image.height)];
    let smaller = resize_image(&image, size, used).ok()?;
    match ImageFormat::from_signature(file)? {
        ImageFormat::Png | ImageFormat::Ktx2 => {}
        ImageFormat::WebP => return encode_webp(&smaller),
        _ => return encode_jpeg(&smaller),
    }
    let is_opaque = smaller.rgba.as_chunks::<4>().0.iter().all(|pixel| pixel[3] == u8::MAX);
    Some(if is_opaque { encode_png_opaque(&smaller) } else { encode_png(&smaller) })
}

/// Pixel format of colours: averaged in linear light, weighted by opacity.
struct Colours {
    /// Linear light of each byte.
    light: [f32; 256],
}

impl Colours {
    fn new() -> Self {
        Self { light: std::array::from_fn(|byte| linear_light(byte as f32 / 255.0)) }
    }
}

impl PixelFormat for Colours {
    type InputPixel = [u8; 4];
    type OutputPixel = [u8; 4];
    type Accumulator = [f32; 4];

    fn new() -> [f32; 4] {
        [0.0; 4]
    }

    fn add(&self, sum: &mut [f32; 4], [r, g, b, a]: [u8; 4], weight: f32) {
        let opacity = weight * f32::from(a) / 255.0;
        let light = |byte: u8| self.light[usize::from(byte)];
        Self::add_acc(sum, [light(r), light(g), light(b), 1.0], opacity);
    }

    fn add_acc(sum: &mut [f32; 4], other: [f32; 4], weight: f32) {
        sum.iter_mut().zip(other).for_each(|(sum, value)| *sum += weight * value);
    }

    fn into_pixel(&self, [r, g, b, opacity]: [f32; 4]) -> [u8; 4] {
        if opacity <= 0.0 {
            return [0; 4];
        }
        let [r, g, b] = [r, g, b].map(|light| 255.0 * srgb((light / opacity).clamp(0.0, 1.0)));
        [r, g, b, 255.0 * opacity].map(|value| value.round() as u8)
    }
}

/// Pixel format of numbers: averaged without conversion.
struct Numbers;

impl PixelFormat for Numbers {
    type InputPixel = [u8; 4];
    type OutputPixel = [u8; 4];
    type Accumulator = [f32; 4];

    fn new() -> [f32; 4] {
        [0.0; 4]
    }

    fn add(&self, sum: &mut [f32; 4], pixel: [u8; 4], weight: f32) {
        Self::add_acc(sum, pixel.map(f32::from), weight);
    }

    fn add_acc(sum: &mut [f32; 4], other: [f32; 4], weight: f32) {
        Colours::add_acc(sum, other, weight);
    }

    fn into_pixel(&self, sum: [f32; 4]) -> [u8; 4] {
        sum.map(|value| value.round() as u8)
    }
}

/// Resizes an image: colours in linear light, numbers by mean, directions normalised.
fn resize_image(image: &Image, size: [usize; 2], used: ImageUse) -> Result<Image, resize::Error> {
    let mut pixels = match used {
        ImageUse::Colours => resample(image, size, Colours::new(), Type::Lanczos3)?,
        _ => resample(image, size, Numbers, Type::Custom(Filter::box_filter(0.5)))?,
    };
    if used == ImageUse::Normals {
        pixels.iter_mut().for_each(normalise);
    }
    Ok(Image { width: size[0], height: size[1], rgba: pixels.into_flattened() })
}

fn resample<P>(image: &Image, [width, height]: [usize; 2], of: P, kernel: Type) -> Result<Vec<[u8; 4]>, resize::Error>
where
    P: PixelFormat<InputPixel = [u8; 4], OutputPixel = [u8; 4]>,
{
    let mut pixels = vec![[0; 4]; width * height];
    let mut resizer = Resizer::new(image.width, image.height, width, height, of, kernel)?;
    resizer.resize(image.rgba.as_chunks().0, &mut pixels)?;
    Ok(pixels)
}

fn normalise(pixel: &mut [u8; 4]) {
    let direction: [f32; 3] = std::array::from_fn(|axis| f32::from(pixel[axis]) / 127.5 - 1.0);
    let length = direction.iter().map(|x| x * x).sum::<f32>().sqrt();
    if length > 0.1 {
        (0..3).for_each(|axis| pixel[axis] = ((direction[axis] / length + 1.0) * 127.5).round() as u8);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: usize, height: usize, pixel: impl Fn(usize) -> [u8; 4]) -> Image {
        Image { width, height, rgba: (0..width * height).flat_map(pixel).collect() }
    }

    fn resize_file(image: &Image, used: ImageUse, side: usize) -> Option<Image> {
        Textures::new(side).convert(&encode_png(image), used).map(|file| decode_image(&file).unwrap())
    }

    #[test]
    fn the_longer_side_is_as_long_as_asked_and_small_images_keep_every_byte() {
        let long = image(60, 7, |_| [9, 90, 200, 255]);
        let small = resize_file(&long, ImageUse::Colours, 30).unwrap();
        assert_eq!((small.width, small.height), (30, 4));
        assert!(small.rgba.as_chunks::<4>().0.iter().all(|pixel| *pixel == [9, 90, 200, 255]), "{:?}", small.rgba);
        let side = |pixels| resize_file(&image(pixels, 1, |_| [1; 4]), ImageUse::Numbers, 8).map(|small| small.width);
        assert_eq!([side(8), side(9)], [None, Some(8)]);
    }

    #[test]
    fn light_is_averaged_for_colours_and_numbers_for_numbers() {
        let stripes = image(64, 64, |at| if at % 2 == 0 { [0, 0, 0, 255] } else { [255; 4] });
        let grey = |used| resize_file(&stripes, used, 32).unwrap().rgba[4 * (16 * 32 + 16)];
        assert!((186..=190).contains(&grey(ImageUse::Colours)), "{}", grey(ImageUse::Colours));
        assert!((127..=128).contains(&grey(ImageUse::Numbers)), "{}", grey(ImageUse::Numbers));
    }

    #[test]
    fn what_is_not_seen_has_no_colour_to_give() {
        let cut_out = image(64, 64, |at| if at % 64 < 32 { [200, 0, 0, 255] } else { [0, 255, 0, 0] });
        let small = resize_file(&cut_out, ImageUse::Colours, 16).unwrap();
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
        let small = resize_file(&bumps, ImageUse::Normals, 32).unwrap();
        assert!(small.rgba.as_chunks::<4>().0.iter().all(|pixel| pixel[2] >= 254), "{:?}", small.rgba);
    }

    #[test]
    fn a_jpeg_and_a_webp_stay_such_and_what_is_neither_is_said() {
        let file = encode_jpeg(&image(64, 32, |_| [40, 80, 120, 255])).unwrap();
        let textures = Textures::new(16);
        let webp = encode_webp(&image(64, 32, |_| [40, 80, 120, 9])).unwrap();
        let small = textures.convert(&webp, ImageUse::Numbers).unwrap();
        assert_eq!((ImageFormat::from_signature(&small), image_size(&small)), (Some(ImageFormat::WebP), Some([16, 8])));
        let small = textures.convert(&file, ImageUse::Colours).unwrap();
        assert!(small.starts_with(b"\xff\xd8") && image_size(&small) == Some([16, 8]));
        assert_eq!(textures.note(), None);
        for other in [&b"RIFF0000WEBP"[..], b"", &file[..40]] {
            assert_eq!(textures.convert(other, ImageUse::Colours), None);
        }
        assert!(textures.note().is_some());
    }
}
