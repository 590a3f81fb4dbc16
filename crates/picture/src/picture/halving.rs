//! Images too large to keep, reduced row by row while they are read.

use super::Image;
use super::pixels::MOST_PIXELS;
use crate::mesh::{linear_light, srgb};

/// Meaning of pixels, which says how they are averaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PixelMeaning {
    /// Colours with opacity: light is averaged.
    Colours,
    /// Numbers, such as directions or roughness.
    Numbers,
}

/// Averages squares of pixels whose side is a power of two.
pub(super) struct Halving {
    // Side of the squares.
    side: usize,
    meaning: PixelMeaning,
    // Value of each byte.
    values: [f32; 256],
    // Sums of the current row of squares, weighted by opacity for colours; the last is the sum of opacity.
    sums: Vec<[f32; 4]>,
    // Width of the image, and rows added to `sums`.
    width: usize,
    n_rows: usize,
    image: Image,
}

impl Halving {
    /// Prepares an image of `width` x `height` pixels to have at most [`MOST_PIXELS`].
    pub fn new(width: usize, height: usize, meaning: PixelMeaning) -> Self {
        let n_squares = |side: usize| [width.div_ceil(side), height.div_ceil(side)];
        let mut side = 1;
        while n_squares(side).iter().product::<usize>() > MOST_PIXELS {
            side *= 2;
        }
        let [columns, rows] = n_squares(side);
        let value = |byte: usize| match meaning {
            PixelMeaning::Colours => linear_light(byte as f32 / 255.0),
            PixelMeaning::Numbers => byte as f32,
        };
        let image = Image { width: columns, height: rows, rgba: Vec::with_capacity(4 * columns * rows) };
        let sums = vec![[0.0; 4]; columns];
        Self { side, meaning, values: std::array::from_fn(value), sums, width, n_rows: 0, image }
    }

    /// Adds the next row, of `CHANNELS` bytes a pixel: grey, grey and opacity, RGB or RGBA.
    pub fn add_row<const CHANNELS: usize>(&mut self, row: &[u8]) {
        for (at, pixel) in row.as_chunks::<CHANNELS>().0.iter().enumerate() {
            let alpha = if CHANNELS.is_multiple_of(2) { f32::from(pixel[CHANNELS - 1]) } else { 255.0 };
            let weight = if self.meaning == PixelMeaning::Colours { alpha } else { 1.0 };
            let channel = |at: usize| self.values[usize::from(pixel[if CHANNELS < 3 { 0 } else { at }])];
            let added = [weight * channel(0), weight * channel(1), weight * channel(2), alpha];
            self.sums[at / self.side].iter_mut().zip(added).for_each(|(sum, value)| *sum += value);
        }
        self.n_rows += 1;
        if self.n_rows == self.side {
            self.finish_squares();
        }
    }

    /// Returns the reduced image; `None` if rows are missing.
    pub fn finish(mut self) -> Option<Image> {
        // The last squares may have fewer rows.
        if self.n_rows > 0 {
            self.finish_squares();
        }
        let Image { width, height, rgba } = &self.image;
        (rgba.len() == 4 * width * height).then_some(self.image)
    }

    fn finish_squares(&mut self) {
        for (at, sum) in self.sums.iter_mut().enumerate() {
            let n = (self.n_rows * self.side.min(self.width - at * self.side)) as f32;
            let [r, g, b, alpha] = std::mem::take(sum);
            let pixel = match self.meaning {
                PixelMeaning::Numbers => [r, g, b].map(|value| value / n),
                PixelMeaning::Colours if alpha > 0.0 => [r, g, b].map(|light| 255.0 * srgb(light / alpha)),
                PixelMeaning::Colours => [0.0; 3],
            };
            self.image.rgba.extend([pixel[0], pixel[1], pixel[2], alpha / n].map(|value| value.round() as u8));
        }
        self.n_rows = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // Halves an image by a side of two, as images above the limit are.
    fn halve(image: &Image, meaning: PixelMeaning) -> Image {
        let mut halving = Halving::new(image.width, image.height, meaning);
        let [width, height] = [image.width, image.height].map(|side| side.div_ceil(2));
        (halving.side, halving.sums) = (2, vec![[0.0; 4]; width]);
        (halving.image.width, halving.image.height) = (width, height);
        image.rgba.chunks(4 * image.width).for_each(|row| halving.add_row::<4>(row));
        halving.finish().unwrap()
    }

    #[test]
    fn light_is_averaged_and_numbers_are() {
        let rgba = [[0, 0, 0, 255], [255, 255, 255, 255], [10, 20, 30, 255]].concat();
        let image = Image { width: 3, height: 1, rgba };
        let colours = halve(&image, PixelMeaning::Colours);
        assert_eq!((colours.width, colours.height), (2, 1));
        // Half of the light is 188 in sRGB.
        assert_eq!(colours.rgba, [188, 188, 188, 255, 10, 20, 30, 255]);
        assert_eq!(halve(&image, PixelMeaning::Numbers).rgba, [128, 128, 128, 255, 10, 20, 30, 255]);
    }

    #[test]
    fn transparent_pixels_add_no_colour() {
        let rgba = [[200, 100, 50, 255], [0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]].concat();
        let image = Image { width: 2, height: 2, rgba };
        assert_eq!(halve(&image, PixelMeaning::Colours).rgba, [200, 100, 50, 64]);
    }

    #[test]
    fn the_side_is_the_smallest_that_fits() {
        for (width, height, side) in [(8192, 8192, 1), (8193, 8192, 2), (16384, 16384, 2), (65535, 65535, 8)] {
            assert_eq!(Halving::new(width, height, PixelMeaning::Colours).side, side);
        }
    }
}
