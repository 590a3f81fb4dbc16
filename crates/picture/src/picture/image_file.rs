//! Image files.

use std::io::Cursor;

use image_webp::{ColorType, WebPDecoder, WebPEncoder};
use jpeg_encoder::{Encoder, ImageBuffer, JpegColorType, rgb_to_ycbcr};
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::halving::{Halving, PixelMeaning};
use super::pixels::{MOST_PIXELS, add_opacity, check_size};
use super::{Image, ktx2};

const WEBP_BYTES: usize = 16;
/// Quality of JPEG files, 1 to 100.
const QUALITY: u8 = 90;

/// Format of image files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ImageFormat {
    /// PNG.
    Png,
    /// JPEG.
    Jpeg,
    /// WebP.
    WebP,
    /// KTX 2.0 with Basis Universal; decoded with the feature `ktx2`.
    Ktx2,
}

impl ImageFormat {
    /// Recognises a format by its signature.
    ///
    /// ```
    /// # use neural_mesh_picture as neural_mesh;
    /// use neural_mesh::picture::ImageFormat;
    /// assert_eq!(ImageFormat::from_signature(b"\xff\xd8\xff\xe0"), Some(ImageFormat::Jpeg));
    /// assert_eq!(ImageFormat::from_signature(b"GIF89a"), None);
    /// ```
    pub fn from_signature(bytes: &[u8]) -> Option<Self> {
        match bytes {
            [0x89, b'P', b'N', b'G', ..] => Some(Self::Png),
            [0xff, 0xd8, ..] => Some(Self::Jpeg),
            [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Some(Self::WebP),
            [0xab, b'K', b'T', b'X', b' ', b'2', b'0', 0xbb, ..] => Some(Self::Ktx2),
            _ => None,
        }
    }

    /// Returns the usual name.
    ///
    /// ```
    /// # use neural_mesh_picture as neural_mesh;
    /// assert_eq!(neural_mesh::picture::ImageFormat::WebP.name(), "WebP");
    /// ```
    pub fn name(self) -> &'static str {
        match self {
            Self::Png => "PNG",
            Self::Jpeg => "JPEG",
            Self::WebP => "WebP",
            Self::Ktx2 => "KTX2",
        }
    }
}

/// Decodes a PNG, JPEG, WebP or (feature `ktx2`) KTX2 file by its content.
///
/// An image above 67 million pixels (8192 x 8192) is halved, averaging light, until it has no more. Returns `None` for
/// other, damaged and still larger files. An animated WebP gives its first frame.
///
/// ```
/// # use neural_mesh_picture as neural_mesh;
/// use neural_mesh::picture::{Image, decode_image, encode_png};
/// let image = Image { width: 2, height: 1, rgba: vec![9, 8, 7, 255, 1, 2, 3, 4] };
/// assert_eq!(decode_image(&encode_png(&image)), Some(image));
/// assert_eq!(decode_image(b"GIF89a"), None);
/// ```
pub fn decode_image(bytes: &[u8]) -> Option<Image> {
    decode(bytes, PixelMeaning::Colours)
}

/// Decodes an image file like [`decode_image`]; halving averages numbers, such as directions or roughness, not light.
///
/// ```
/// # use neural_mesh_picture as neural_mesh;
/// use neural_mesh::picture::{Image, decode_numbers, encode_png};
/// let image = Image { width: 2, height: 1, rgba: vec![9, 8, 7, 255, 1, 2, 3, 4] };
/// assert_eq!(decode_numbers(&encode_png(&image)), Some(image));
/// ```
pub fn decode_numbers(bytes: &[u8]) -> Option<Image> {
    decode(bytes, PixelMeaning::Numbers)
}

fn decode(bytes: &[u8], meaning: PixelMeaning) -> Option<Image> {
    match ImageFormat::from_signature(bytes)? {
        ImageFormat::Png => decode_png(bytes, meaning),
        ImageFormat::Jpeg => decode_jpeg(bytes, meaning),
        ImageFormat::WebP => decode_webp(bytes, meaning),
        ImageFormat::Ktx2 => ktx2::decode(bytes),
    }
}

/// Returns why [`decode_image`] cannot decode these bytes, with a remedy.
///
/// ```
/// # use neural_mesh_picture as neural_mesh;
/// use neural_mesh::picture::image_problem;
/// assert_eq!(image_problem(b"GIF89a"), "is not PNG, JPEG or WebP: convert it to one of these");
/// assert_eq!(image_problem(b"\xff\xd8\xff\xe0"), "is not a complete JPEG: save it again");
/// ```
pub fn image_problem(bytes: &[u8]) -> String {
    let too_large = image_size(bytes).filter(|[width, height]| width * height > 0);
    let too_large = too_large.filter(|&[width, height]| check_size(width, height, bytes.len()).is_none());
    match (ImageFormat::from_signature(bytes), too_large) {
        (Some(ImageFormat::Ktx2), _) => ktx2::PROBLEM.into(),
        (Some(_), Some([width, height])) => {
            format!("has {width} x {height} pixels, too many for its {} bytes: save it smaller", bytes.len())
        }
        (Some(format), _) => format!("is not a complete {}: save it again", format.name()),
        (None, _) => "is not PNG, JPEG or WebP: convert it to one of these".into(),
    }
}

/// Reads width and height from the header of a PNG, JPEG, WebP or KTX2 file.
///
/// ```
/// # use neural_mesh_picture as neural_mesh;
/// use neural_mesh::picture::{Image, encode_png, image_size};
/// let image = Image { width: 2, height: 1, rgba: vec![9, 8, 7, 255, 1, 2, 3, 4] };
/// assert_eq!(image_size(&encode_png(&image)), Some([2, 1]));
/// assert_eq!(image_size(b"GIF89a"), None);
/// ```
pub fn image_size(bytes: &[u8]) -> Option<[usize; 2]> {
    match ImageFormat::from_signature(bytes)? {
        ImageFormat::Png => {
            let reader = png::Decoder::new(Cursor::new(bytes)).read_info().ok()?;
            Some([reader.info().width, reader.info().height].map(|side| side as usize))
        }
        ImageFormat::Jpeg => {
            let mut decoder = jpeg_decoder(bytes, ColorSpace::RGB);
            decoder.decode_headers().ok()?;
            decoder.dimensions().map(<[usize; 2]>::from)
        }
        ImageFormat::WebP => {
            let (width, height) = WebPDecoder::new(Cursor::new(bytes)).ok()?.dimensions();
            Some([width, height].map(|side| side as usize))
        }
        ImageFormat::Ktx2 => {
            // Width and height are the third and fourth number after the signature of twelve bytes.
            let word = |at: usize| Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?) as usize);
            Some([word(20)?, word(24)?.max(1)])
        }
    }
}

/// Encodes an image as lossless WebP; `None` if it has no pixels or a side above 16,384.
///
/// ```
/// # use neural_mesh_picture as neural_mesh;
/// use neural_mesh::picture::{Image, decode_image, encode_webp};
/// let image = Image { width: 2, height: 1, rgba: vec![9, 8, 7, 255, 1, 2, 3, 4] };
/// assert_eq!(decode_image(&encode_webp(&image).unwrap()), Some(image));
/// ```
pub fn encode_webp(image: &Image) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    let [width, height] = [u32::try_from(image.width).ok()?, u32::try_from(image.height).ok()?];
    WebPEncoder::new(&mut bytes).encode(&image.rgba, width, height, ColorType::Rgba8).ok()?;
    Some(bytes)
}

/// Encodes an image as a JPEG, without its alpha; `None` if it has no pixels or a side above 65,535.
///
/// ```
/// # use neural_mesh_picture as neural_mesh;
/// use neural_mesh::picture::{Image, decode_image, encode_jpeg};
/// let grey = Image { width: 2, height: 1, rgba: vec![128, 128, 128, 255, 128, 128, 128, 255] };
/// assert_eq!(decode_image(&encode_jpeg(&grey).unwrap()), Some(grey));
/// ```
pub fn encode_jpeg(image: &Image) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    let [width, height] = [u16::try_from(image.width).ok()?, u16::try_from(image.height).ok()?];
    Encoder::new(&mut bytes, QUALITY).encode_image(JpegPixels { rgba: &image.rgba, width, height }).ok()?;
    Some(bytes)
}

/// Pixels as the encoder reads them: its own types are nine, and the encoder would be compiled for each.
struct JpegPixels<'a> {
    rgba: &'a [u8],
    width: u16,
    height: u16,
}

impl ImageBuffer for JpegPixels<'_> {
    fn get_jpeg_color_type(&self) -> JpegColorType {
        JpegColorType::Ycbcr
    }

    fn width(&self) -> u16 {
        self.width
    }

    fn height(&self) -> u16 {
        self.height
    }

    fn fill_buffers(&self, row: u16, buffers: &mut [Vec<u8>; 4]) {
        let n = 4 * usize::from(self.width);
        for pixel in self.rgba[usize::from(row) * n..][..n].chunks_exact(4) {
            let (y, cb, cr) = rgb_to_ycbcr(pixel[0], pixel[1], pixel[2]);
            buffers[0].push(y);
            buffers[1].push(cb);
            buffers[2].push(cr);
        }
    }
}

fn decode_png(bytes: &[u8], meaning: PixelMeaning) -> Option<Image> {
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().ok()?;
    // The check precedes the allocation of pixels: the header may claim any size.
    let [width, height] = [reader.info().width, reader.info().height].map(|side| side as usize);
    let n = check_size(width, height, bytes.len())?;
    let (kind, _) = reader.output_color_type();
    if n > MOST_PIXELS && !reader.info().interlaced {
        let mut halving = Halving::new(width, height, meaning);
        while let Some(row) = reader.next_row().ok()? {
            add_row(&mut halving, row.data(), kind);
        }
        return halving.finish();
    }
    let mut pixels = vec![0; reader.output_buffer_size()?];
    let frame = reader.next_frame(&mut pixels).ok()?;
    pixels.truncate(frame.buffer_size());
    to_image(pixels, [width, height], frame.color_type, meaning)
}

fn jpeg_decoder(bytes: &[u8], kind: ColorSpace) -> JpegDecoder<ZCursor<&[u8]>> {
    let most = usize::from(u16::MAX);
    let options = DecoderOptions::default().jpeg_set_out_colorspace(kind).set_max_width(most).set_max_height(most);
    JpegDecoder::new_with_options(ZCursor::new(bytes), options)
}

fn decode_jpeg(bytes: &[u8], meaning: PixelMeaning) -> Option<Image> {
    let size = image_size(bytes)?;
    let n = check_size(size[0], size[1], bytes.len())?;
    // The decoder needs room for the whole image; three bytes a pixel are the least.
    let (space, kind) = match n > MOST_PIXELS {
        true => (ColorSpace::RGB, png::ColorType::Rgb),
        false => (ColorSpace::RGBA, png::ColorType::Rgba),
    };
    to_image(jpeg_decoder(bytes, space).decode().ok()?, size, kind, meaning)
}

fn decode_webp(bytes: &[u8], meaning: PixelMeaning) -> Option<Image> {
    let mut decoder = WebPDecoder::new(Cursor::new(bytes)).ok()?;
    let (width, height) = decoder.dimensions();
    let [width, height] = [width, height].map(|side| side as usize);
    let n = check_size(width, height, bytes.len())?;
    // A damaged file may otherwise ask for any amount.
    decoder.set_memory_limit(WEBP_BYTES * n + bytes.len());
    let mut pixels = vec![0; decoder.output_buffer_size()?];
    decoder.read_image(&mut pixels).ok()?;
    let kind = if decoder.has_alpha() { png::ColorType::Rgba } else { png::ColorType::Rgb };
    to_image(pixels, [width, height], kind, meaning)
}

/// Makes an image of decoded pixels, which is halved if it is too large.
fn to_image(
    pixels: Vec<u8>,
    [width, height]: [usize; 2],
    kind: png::ColorType,
    meaning: PixelMeaning,
) -> Option<Image> {
    if width * height > MOST_PIXELS {
        let mut halving = Halving::new(width, height, meaning);
        pixels.chunks_exact(kind.samples() * width).for_each(|row| add_row(&mut halving, row, kind));
        return halving.finish();
    }
    let rgba = match kind.samples() {
        1 => pixels.iter().flat_map(|&grey| [grey, grey, grey, 255]).collect(),
        2 => pixels.as_chunks::<2>().0.iter().flat_map(|&[grey, alpha]| [grey, grey, grey, alpha]).collect(),
        3 => add_opacity(&pixels),
        _ => pixels,
    };
    (rgba.len() == 4 * width * height).then_some(Image { width, height, rgba })
}

fn add_row(halving: &mut Halving, row: &[u8], kind: png::ColorType) {
    match kind.samples() {
        1 => halving.add_row::<1>(row),
        2 => halving.add_row::<2>(row),
        3 => halving.add_row::<3>(row),
        _ => halving.add_row::<4>(row),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_webp_comes_back() {
        let rgba: Vec<u8> = (0..4 * 12).map(|x| (20 * x % 251) as u8).collect();
        let image = Image { width: 4, height: 3, rgba };
        let file = encode_webp(&image).unwrap();
        assert_eq!((ImageFormat::from_signature(&file), image_size(&file)), (Some(ImageFormat::WebP), Some([4, 3])));
        assert_eq!(decode_image(&file), Some(image));
        for length in 0..file.len() - 1 {
            assert_eq!(decode_image(&file[..length]), None, "{length}");
        }
    }

    #[test]
    fn a_ktx2_says_its_size_before_it_is_decoded() {
        let mut file = b"\xabKTX 20\xbb\r\n\x1a\n".to_vec();
        file.extend([0u32, 1, 640, 480].iter().flat_map(|word| word.to_le_bytes()));
        assert_eq!((image_size(&file), decode_image(&file)), (Some([640, 480]), None));
        assert_eq!(image_size(&file[..22]), None);
        assert_eq!(
            [&b"\x89PNG\r\n\x1a\n"[..], b"\xff\xd8\xff\xe0", b"RIFF0000WEBP"].map(decode_image),
            [None, None, None]
        );
    }
}
