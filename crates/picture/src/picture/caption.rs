//! Captions below panels, in a bitmap font.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster};

use super::Image;

const SIZE: RasterHeight = RasterHeight::Size16;
const LINE: usize = 20;
// Space above the first and below the last line in pixels.
const SPACE: usize = 8;
const INK: [u8; 3] = [44, 54, 70];

/// Breaks the lines of captions between words where they are wider than a panel; words stay whole.
pub fn wrap(captions: &[String], width: usize) -> Vec<String> {
    // All letters of the font have one width.
    let most = width / letter(' ').map_or(1, |raster| raster.width());
    captions.iter().map(|text| text.lines().map(|line| wrap_line(line, most)).collect::<Vec<_>>().join("\n")).collect()
}

fn wrap_line(line: &str, most: usize) -> String {
    let (mut wrapped, mut n_letters) = (String::new(), 0);
    for word in line.split(' ') {
        let length = word.chars().count();
        if n_letters > 0 {
            let fits = n_letters + 1 + length <= most;
            wrapped.push(if fits { ' ' } else { '\n' });
            n_letters = if fits { n_letters + 1 } else { 0 };
        }
        wrapped.push_str(word);
        n_letters += length;
    }
    wrapped
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_break_between_words_where_a_panel_is_narrow() {
        let captions = ["simplified\nring: place of the largest distance".into(), "a_name_without_spaces.obj".into()];
        let width = letter(' ').unwrap().width();
        assert_eq!(wrap(&captions, 40 * width), captions);
        let narrow = ["simplified\nring: place\nof the\nlargest\ndistance", "a_name_without_spaces.obj"];
        assert_eq!(wrap(&captions, 12 * width), narrow);
        assert_eq!(height(&wrap(&captions, 12 * width)), 5 * LINE + 2 * SPACE);
    }
}
