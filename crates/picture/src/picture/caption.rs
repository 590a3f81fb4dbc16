//! Captions below panels, in a bitmap font.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster};

use super::Image;

const SIZE: RasterHeight = RasterHeight::Size16;
const LINE: usize = 20;
// Space above the first and below the last line in pixels.
const SPACE: usize = 8;
const INK: [u8; 3] = [44, 54, 70];

/// Returns the height of the longest caption in pixels.
pub fn height(captions: &[String]) -> usize {
    match captions.iter().map(|text| text.lines().count()).max() {
        None | Some(0) => 0,
        Some(lines) => lines * LINE + 2 * SPACE,
    }
}

/// Writes lines of text below row `below`, centred at column `middle`.
pub fn write(image: &mut Image, text: &str, middle: usize, below: usize) {
    for (number, line) in text.lines().enumerate() {
        let width: usize = line.chars().filter_map(letter).map(|raster| raster.width()).sum();
        let mut left = middle.saturating_sub(width / 2);
        for raster in line.chars().filter_map(letter) {
            blend(image, raster.raster(), left, below + SPACE + number * LINE);
            left += raster.width();
        }
    }
}

fn letter(c: char) -> Option<noto_sans_mono_bitmap::RasterizedChar> {
    get_raster(c, FontWeight::Regular, SIZE).or_else(|| get_raster('?', FontWeight::Regular, SIZE))
}

fn blend(image: &mut Image, letter: &[&[u8]], left: usize, top: usize) {
    for (y, row) in letter.iter().enumerate() {
        for (x, &cover) in row.iter().enumerate().filter(|&(x, _)| left + x < image.width) {
            let at = ((top + y) * image.width + left + x) * 4;
            let Some(pixel) = image.rgba.get_mut(at..at + 3) else { continue };
            for (channel, ink) in pixel.iter_mut().zip(INK) {
                let mixed = u32::from(*channel) * (255 - u32::from(cover)) + u32::from(ink) * u32::from(cover);
                *channel = (mixed / 255) as u8;
            }
        }
    }
}
