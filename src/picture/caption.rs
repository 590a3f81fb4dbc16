//! Lines of text below a panel, from letters that are already drawn.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster};

use super::Image;

const SIZE: RasterHeight = RasterHeight::Size16;
/// Rows of a line of text.
const LINE: usize = 20;
/// Rows above the first and below the last line.
const SPACE: usize = 8;
/// Colour of the letters, sRGB.
const INK: [u8; 3] = [44, 54, 70];

/// Rows that the longest of the captions takes; 0 where all are empty.
pub fn height(captions: &[String]) -> usize {
    match captions.iter().map(|text| text.lines().count()).max() {
        None | Some(0) => 0,
        Some(lines) => lines * LINE + 2 * SPACE,
    }
}

/// Writes lines of text, each centred at a column, below a row. What lies outside the image is cut off.
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

/// A letter, or a question mark for one that the font lacks.
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
