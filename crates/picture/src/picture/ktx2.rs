//! Decoding of KTX 2.0: the base level of a flat texture.
//!
//! Only the decoders of blocks are called: the transcoder would bring tables for all formats of graphics cards, a megabyte.

use std::borrow::Cow;
use std::io::Read;

use basisu::basislz::etc1s::Etc1sTranscoder;
use basisu::uastc::unpack::unpack_uastc;
use ruzstd::decoding::StreamingDecoder;

use super::Image;
use super::pixels::{add_opacity, check_size};

pub(super) const PROBLEM: &str =
    "is not a complete KTX2 of ETC1S, UASTC or RGBA8 within 67 million pixels: give it as PNG, JPEG or WebP";

const MAGIC: [u8; 12] = *b"\xabKTX 20\xbb\r\n\x1a\n";

/// `VK_FORMAT_R8G8B8_UNORM` and `_SRGB`.
const RGB8: [u32; 2] = [23, 29];
/// `VK_FORMAT_R8G8B8A8_UNORM` and `_SRGB`.
const RGBA8: [u32; 2] = [37, 43];

// Colour models of the data format descriptor.
const ETC1S: u8 = 163;
const UASTC: u8 = 166;
// Channel number of the ETC1S sample that holds the second of two numbers.
const ETC1S_GREEN: u8 = 4;
// Channel number of a UASTC sample of two numbers, the second of which is stored as opacity.
const UASTC_RED_GREEN: u8 = 5;

// Supercompression schemes.
const BASIS_LZ: u32 = 1;
const ZSTANDARD: u32 = 2;
/// Zstandard window in bytes that the specification asks decoders to support.
const WINDOW: usize = 8 << 20;

// Bytes of BasisLZ global data: its header, and its description of each image.
const GLOBAL: usize = 20;
const IMAGE: usize = 20;

/// Decodes a KTX2 file of a flat texture.
pub(super) fn decode(bytes: &[u8]) -> Option<Image> {
    let file = Ktx2::read(bytes)?;
    let [width, height] = file.size;
    let n = check_size(width, height, 0)?;
    // Format 0 means Basis Universal; its variant is in the descriptor.
    let mut rgba = match (file.vk_format, file.model) {
        (format, _) if RGBA8.contains(&format) => file.inflate(4 * n)?.into_owned(),
        (format, _) if RGB8.contains(&format) => add_opacity(&file.inflate(3 * n)?),
        (0, ETC1S) if file.scheme == BASIS_LZ => file.etc1s()?,
        (0, UASTC) => file.uastc()?,
        _ => return None,
    };
    if file.has_two_numbers() {
        rgba.as_chunks_mut::<4>().0.iter_mut().for_each(|pixel| *pixel = [pixel[0], pixel[3], 0, u8::MAX]);
    }
    (rgba.len() == 4 * n).then_some(Image { width, height, rgba })
}

struct Ktx2<'a> {
    vk_format: u32,
    size: [usize; 2],
    scheme: u32,
    n_images: usize,
    // Colour model, and the channels of up to two samples.
    model: u8,
    channels: Vec<u8>,
    global: &'a [u8],
    level: &'a [u8],
}

impl<'a> Ktx2<'a> {
    fn read(bytes: &'a [u8]) -> Option<Self> {
        let read_word = |at: usize| word(bytes, at);
        let [depth, layers, faces, levels] = [read_word(28)?, read_word(32)?, read_word(36)?, read_word(40)?];
        // Everything but a flat texture is rejected, as for glTF.
        if !bytes.starts_with(&MAGIC) || depth > 1 || layers > 1 || faces != 1 || levels > 32 {
            return None;
        }
        let descriptor = bytes_at(bytes, read_word(48)?.into(), read_word(52)?.into())?;
        // A sample is four words; the first ends with its channel.
        let samples = descriptor.get(28..)?.as_chunks::<16>().0.iter().take(2);
        Some(Self {
            vk_format: read_word(12)?,
            size: [read_word(20)? as usize, read_word(24)? as usize],
            scheme: read_word(44)?,
            n_images: levels.max(1) as usize,
            model: descriptor[12],
            channels: samples.map(|sample| sample[3] & 15).collect(),
            global: bytes_at(bytes, long(bytes, 64)?, long(bytes, 72)?)?,
            level: bytes_at(bytes, long(bytes, 80)?, long(bytes, 88)?)?,
        })
    }

    fn has_two_numbers(&self) -> bool {
        match self.model {
            _ if self.vk_format != 0 => false,
            ETC1S => self.channels.get(1) == Some(&ETC1S_GREEN),
            _ => self.channels.first() == Some(&UASTC_RED_GREEN),
        }
    }

    fn inflate(&self, n: usize) -> Option<Cow<'a, [u8]>> {
        match self.scheme {
            0 => (self.level.len() == n).then_some(self.level.into()),
            ZSTANDARD => {
                let mut decoder = StreamingDecoder::new_with_max_window_size(self.level, n.max(WINDOW) as u64).ok()?;
                let mut bytes = vec![0; n];
                decoder.read_exact(&mut bytes).ok()?;
                // Bytes after the level mean a damaged file.
                (decoder.read(&mut [0]).ok()? == 0).then_some(bytes.into())
            }
            _ => None,
        }
    }

    fn n_blocks(&self) -> [usize; 2] {
        self.size.map(|side| side.div_ceil(4))
    }

    /// Decodes UASTC: 16 bytes per block of 4 x 4 pixels.
    fn uastc(&self) -> Option<Vec<u8>> {
        let ([width, height], [columns, rows]) = (self.size, self.n_blocks());
        let blocks = self.inflate(16 * columns * rows)?;
        let mut rgba = vec![0; 4 * width * height];
        for (at, block) in blocks.as_chunks::<16>().0.iter().enumerate() {
            let pixels = unpack_uastc(block, false)?;
            let [left, top] = [at % columns, at / columns].map(|number| 4 * number);
            // Blocks at the right and lower side reach beyond the image.
            for (row, pixels) in (top..height).zip(pixels.as_chunks::<4>().0) {
                for (column, pixel) in (left..width).zip(pixels) {
                    rgba[4 * (row * width + column)..][..4].copy_from_slice(&pixel.c);
                }
            }
        }
        Some(rgba)
    }

    /// Decodes ETC1S: codebooks, which all levels share, and slices of indices, one for colours and one for opacity.
    fn etc1s(&self) -> Option<Vec<u8>> {
        let (header, rest) = self.global.split_at_checked(GLOBAL)?;
        let codes = rest.get(IMAGE * self.n_images..)?;
        let [n_endpoints, n_selectors] = [0, 2].map(|at| u32::from(u16::from_le_bytes([header[at], header[at + 1]])));
        let [n_bytes, n_selector_bytes, n_table_bytes] = [word(header, 4)?, word(header, 8)?, word(header, 12)?];
        let (endpoints, codes) = codes.split_at_checked(n_bytes as usize)?;
        let (selectors, codes) = codes.split_at_checked(n_selector_bytes as usize)?;
        let tables = codes.get(..n_table_bytes as usize)?;
        let mut decoder = Etc1sTranscoder::new();
        if !decoder.decode_palettes(n_endpoints, endpoints, n_selectors, selectors) || !decoder.decode_tables(tables) {
            return None;
        }
        let slice = |at: usize| bytes_at(self.level, word(rest, at)?.into(), word(rest, at + 4)?.into());
        let ([width, height], [columns, rows]) = (self.size.map(|n| n as u32), self.n_blocks().map(|n| n as u32));
        let mut rgba = vec![0; 4 * self.size[0] * self.size[1]];
        let colours = slice(4)?;
        // A second channel has a slice of its own.
        if self.channels.len() > 1 {
            let opacity = slice(12)?;
            decoder.transcode_image_rgba32(colours, opacity, columns, rows, width, height, None, &mut rgba)?;
        } else {
            decoder.transcode_slice_rgba32(colours, columns, rows, width, height, None, &mut rgba)?;
        }
        Some(rgba)
    }
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

fn long(bytes: &[u8], at: usize) -> Option<u64> {
    Some(u64::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

fn bytes_at(bytes: &[u8], at: u64, n: u64) -> Option<&[u8]> {
    let [at, end] = [at, at.checked_add(n)?].map(|at| usize::try_from(at).ok());
    bytes.get(at?..end?)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    // Files by Basis Universal's encoder: slopes in red and green, waves in blue and opacity; those with opacity have
    // all levels.
    const ETC1S_RGB: &[u8] = include_bytes!("../../../../tests/images/etc1s.ktx2");
    const ETC1S_RGBA: &[u8] = include_bytes!("../../../../tests/images/etc1s_alpha.ktx2");
    const UASTC_RGBA: &[u8] = include_bytes!("../../../../tests/images/uastc_alpha.ktx2");
    const UASTC_ZSTANDARD: &[u8] = include_bytes!("../../../../tests/images/uastc_zstd.ktx2");
    const FILES: [&[u8]; 4] = [ETC1S_RGB, ETC1S_RGBA, UASTC_RGBA, UASTC_ZSTANDARD];

    fn source(width: usize, height: usize, has_alpha: bool) -> Vec<u8> {
        let pixel = |(x, y): (usize, usize)| {
            let slope = |at: usize, n: usize| 255.0 * at as f64 / (n - 1) as f64;
            let wave = |sine: f64| 127.5 + 127.5 * sine;
            let blue = wave((x as f64 / 5.0 + y as f64 / 9.0).sin());
            let opacity = if has_alpha { wave((x as f64 / 7.0 - y as f64 / 6.0).cos()) } else { 255.0 };
            [slope(x, width), slope(y, height), blue, opacity].map(|value| value.round() as u8)
        };
        (0..width * height).flat_map(|at| pixel((at % width, at / width))).collect()
    }

    fn plain(vk_format: u32, [width, height]: [u32; 2], level: &[u8]) -> Vec<u8> {
        // The descriptor of 44 bytes follows the header and one entry of the level index.
        let words = [vk_format, 1, width, height, 0, 0, 1, 1, 0, 104, 44, 0, 0].map(u32::to_le_bytes);
        let longs = [0, 0, 148, level.len() as u64, level.len() as u64].map(u64::to_le_bytes);
        [&MAGIC[..], words.as_flattened(), longs.as_flattened(), &[0; 44], level].concat()
    }

    fn difference(a: &[u8], b: &[u8]) -> f64 {
        let squares = a.iter().zip(b).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2));
        (squares.sum::<f64>() / a.len() as f64).sqrt()
    }

    #[test]
    fn pixels_are_near_those_that_were_encoded_and_those_of_the_reference() {
        // The expected numbers are from pixels that Basis Universal 2.5 decodes.
        for (file, [width, height], has_alpha, bound, expected) in [
            (ETC1S_RGB, [24, 20], false, 16.0, 0xf14d_cea1),
            (ETC1S_RGBA, [24, 20], true, 16.0, 0x8ce8_999f),
            (UASTC_RGBA, [24, 20], true, 8.0, 0xae9c_eb6f),
            (UASTC_ZSTANDARD, [33, 17], false, 8.0, 0x4f9f_5db0),
        ] {
            let image = decode(file).unwrap();
            assert_eq!([image.width, image.height], [width, height]);
            let off = difference(&image.rgba, &source(width, height, has_alpha));
            assert!(off < bound, "{off}");
            let hash = image.rgba.iter().fold(0u32, |hash, &byte| hash.wrapping_mul(31).wrapping_add(byte.into()));
            assert_eq!(hash, expected);
        }
    }

    #[test]
    fn plain_bytes_come_as_they_are() {
        let rgba: Vec<u8> = (0..4 * 6).collect();
        for format in RGBA8 {
            assert_eq!(decode(&plain(format, [3, 2], &rgba)).unwrap().rgba, rgba);
        }
        let image = decode(&plain(29, [4, 2], &rgba)).unwrap();
        assert_eq!((image.width, &image.rgba[..8]), (4, &[0, 1, 2, 255, 3, 4, 5, 255][..]));
        // Another size, and a format of other pixels.
        assert_eq!([decode(&plain(37, [3, 3], &rgba)), decode(&plain(97, [3, 2], &rgba))], [None, None]);
    }

    #[test]
    fn two_numbers_are_red_and_green() {
        for (file, channels) in [(ETC1S_RGBA, &[3, ETC1S_GREEN][..]), (UASTC_RGBA, &[UASTC_RED_GREEN])] {
            let whole = decode(file).unwrap().rgba;
            let mut file = file.to_vec();
            let descriptor = word(&file, 48).unwrap() as usize;
            channels.iter().enumerate().for_each(|(at, channel)| file[descriptor + 28 + 16 * at + 3] = *channel);
            let two = decode(&file).unwrap().rgba;
            let expected = whole.as_chunks::<4>().0.iter().flat_map(|&[r, _, _, a]| [r, a, 0, 255]);
            assert_eq!(two, expected.collect::<Vec<_>>());
        }
    }

    #[test]
    fn what_is_no_flat_texture_or_too_large_is_refused() {
        for (at, value) in [(20, 0), (20, 1 << 23), (28, 2), (32, 2), (36, 6), (40, 33), (44, 3), (48, u32::MAX)] {
            for file in FILES {
                let mut file = file.to_vec();
                file[at..at + 4].copy_from_slice(&u32::to_le_bytes(value));
                assert!(decode(&file).is_none(), "{at}");
            }
        }
        // A window of 2 GiB.
        let mut file = UASTC_ZSTANDARD.to_vec();
        let at = long(&file, 80).unwrap() as usize;
        file[at + 4..at + 6].copy_from_slice(&[0, 21 << 3]);
        assert_eq!(decode(&file), None);
    }

    #[test]
    fn no_part_of_a_file_is_decoded() {
        for file in FILES {
            // The base level is the last one of the file.
            (0..file.len()).for_each(|n| assert!(decode(&file[..n]).is_none(), "{n}"));
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(3000))]

        #[test]
        fn damaged_bytes_give_an_image_of_the_size_they_say_or_none(
            which in 0..4usize,
            changes in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>(), any::<bool>()), 1..6),
        ) {
            let mut file = FILES[which].to_vec();
            for (at, value, is_early) in changes {
                let n = if is_early { 400.min(file.len()) } else { file.len() };
                file[at.index(n)] = value;
            }
            // Skips large sizes in the header, which would only take long.
            prop_assume!(word(&file, 20).zip(word(&file, 24)).is_some_and(|(w, h)| u64::from(w) * u64::from(h) < 1 << 16));
            if let Some(image) = decode(&file) {
                prop_assert_eq!(image.rgba.len(), 4 * image.width * image.height);
            }
        }
    }
}
