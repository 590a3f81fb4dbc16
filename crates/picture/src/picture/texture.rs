//! Textures, sampled between pixels and between levels (Williams, "Pyramidal parametrics", 1983).

use glam::{Vec2, Vec3};

use super::Image;
use super::pixels::{from_srgb, to_srgb};
use crate::mesh::Wrap;

/// Halves an image, averaging light, until no side exceeds `most` pixels; drops opacity.
///
/// ```
/// # use neural_mesh_picture as neural_mesh;
/// use neural_mesh::picture::{Image, shrink};
/// let image = Image { width: 4, height: 2, rgba: vec![255; 32] };
/// assert_eq!(shrink(&image, 2), Image { width: 2, height: 1, rgba: vec![255; 8] });
/// ```
pub fn shrink(image: &Image, most: usize) -> Image {
    let most = most.max(1);
    if image.width.max(image.height) <= most {
        let rgba = image.rgba.as_chunks::<4>().0.iter().flat_map(|&[r, g, b, _]| [r, g, b, 255]);
        return Image { width: image.width, height: image.height, rgba: rgba.collect() };
    }
    let light = light_of_bytes();
    let pixels = image.rgba.as_chunks::<4>().0;
    let mut level = halve([image.width, image.height], |at| linear_colour(&light, pixels[at].first_chunk()));
    while level.width.max(level.height) > most {
        level = level.halve();
    }
    let PyramidLevel { width, height, pixels } = level;
    Image { width, height, rgba: pixels.into_iter().flat_map(to_srgb).collect() }
}

/// Image with coarser copies: three bytes a pixel, and four for all copies.
#[derive(Clone, Debug)]
pub struct Texture {
    width: usize,
    height: usize,
    // The whole image, height x width, row by row from the top left.
    bytes: Vec<[u8; 3]>,
    // Value of each byte: linear light, or a number.
    values: [f32; 256],
    // Levels from half of the image down to one pixel.
    coarser: Vec<PyramidLevel>,
}

// An image in linear light.
#[derive(Clone, Debug)]
struct PyramidLevel {
    width: usize,
    height: usize,
    // height x width, row by row from the top left.
    pixels: Vec<Vec3>,
}

impl Texture {
    pub fn new(image: Image) -> Self {
        Self::with_values(image, light_of_bytes())
    }

    /// Builds the pyramid of an image of numbers from 0 to 1 instead of colours.
    pub fn of_numbers(image: Image) -> Self {
        Self::with_values(image, std::array::from_fn(|byte| byte as f32 / 255.0))
    }

    fn with_values(image: Image, values: [f32; 256]) -> Self {
        let Image { width, height, rgba } = image;
        let bytes: Vec<[u8; 3]> = rgba.as_chunks::<4>().0.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
        // Pixels with opacity go before the copies come, which take as much.
        drop(rgba);
        let half = (bytes.len() > 1).then(|| halve([width, height], |at| linear_colour(&values, bytes.get(at))));
        let coarser = |level: &PyramidLevel| (level.width * level.height > 1).then(|| level.halve());
        let coarser = std::iter::successors(half, coarser).collect();
        Self { width, height, bytes, values, coarser }
    }

    /// Returns the colour at `uv` (v downwards) in linear light, averaged over the span `across` and `down`.
    pub fn colour(&self, uv: Vec2, [across, down]: [Vec2; 2], wrap: [Wrap; 2]) -> Vec3 {
        let size = Vec2::new(self.width as f32, self.height as f32);
        let pixels = (across * size).length().max((down * size).length());
        let last = self.coarser.len();
        let depth = pixels.max(1.0).log2().min(last as f32);
        // Broken coordinates get the coarsest level.
        let depth = if depth.is_finite() { depth } else { last as f32 };
        let level = depth as usize;
        let fine = self.interpolate(level, uv, wrap);
        fine.lerp(self.interpolate((level + 1).min(last), uv, wrap), depth - level as f32)
    }

    fn interpolate(&self, level: usize, uv: Vec2, wrap: [Wrap; 2]) -> Vec3 {
        match level.checked_sub(1).map(|level| &self.coarser[level]) {
            Some(level) => interpolate([level.width, level.height], |at| level.pixels[at], uv, wrap),
            None => {
                let colour = |at: usize| linear_colour(&self.values, self.bytes.get(at));
                interpolate([self.width, self.height], colour, uv, wrap)
            }
        }
    }
}

impl PyramidLevel {
    fn halve(&self) -> Self {
        halve([self.width, self.height], |at| self.pixels[at])
    }
}

fn light_of_bytes() -> [f32; 256] {
    std::array::from_fn(|byte| from_srgb([byte as u8; 3]).x)
}

fn linear_colour(values: &[f32; 256], bytes: Option<&[u8; 3]>) -> Vec3 {
    bytes.map_or(Vec3::ZERO, |bytes| Vec3::from(bytes.map(|byte| values[usize::from(byte)])))
}

fn halve([width, height]: [usize; 2], pixel: impl Fn(usize) -> Vec3) -> PyramidLevel {
    let pixel_at = |x: usize, y: usize| pixel(y.min(height - 1) * width + x.min(width - 1));
    let [width, height] = [width, height].map(|side| (side / 2).max(1));
    let mean = |i: usize| {
        let [x, y] = [2 * (i % width), 2 * (i / width)];
        0.25 * (pixel_at(x, y) + pixel_at(x + 1, y) + pixel_at(x, y + 1) + pixel_at(x + 1, y + 1))
    };
    PyramidLevel { width, height, pixels: (0..width * height).map(mean).collect() }
}

fn interpolate([width, height]: [usize; 2], pixel: impl Fn(usize) -> Vec3, uv: Vec2, wrap: [Wrap; 2]) -> Vec3 {
    let x = uv.x * width as f32 - 0.5;
    let y = uv.y * height as f32 - 0.5;
    let [left, top] = [x.floor(), y.floor()];
    let column = |step: f32| wrap_index(left + step, width, wrap[0]);
    let row = |step: f32| wrap_index(top + step, height, wrap[1]) * width;
    let line = |row: usize| pixel(row + column(0.0)).lerp(pixel(row + column(1.0)), x - left);
    line(row(0.0)).lerp(line(row(1.0)), y - top)
}

fn wrap_index(at: f32, n: usize, wrap: Wrap) -> usize {
    // The cast turns NaN into 0.
    let (at, n) = (at as i64, n as i64);
    let at = match wrap {
        Wrap::Repeat => at.rem_euclid(n),
        Wrap::Clamp => at.clamp(0, n - 1),
        Wrap::Mirror => {
            let at = at.rem_euclid(2 * n);
            at.min(2 * n - 1 - at)
        }
    };
    at as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two_pixels() -> Texture {
        Texture::new(Image { width: 2, height: 1, rgba: vec![0, 0, 0, 255, 255, 255, 255, 255] })
    }

    fn grey(texture: &Texture, u: f32, step: f32, wrap: Wrap) -> f32 {
        texture.colour(Vec2::new(u, 0.5), [Vec2::new(step, 0.0), Vec2::ZERO], [wrap; 2]).x
    }

    #[test]
    fn colours_blend_between_pixels() {
        let texture = two_pixels();
        for (u, wanted) in [(0.25, 0.0), (0.5, 0.5), (0.75, 1.0), (0.375, 0.25)] {
            assert!((grey(&texture, u, 0.0, Wrap::Clamp) - wanted).abs() < 1e-6, "{u}");
        }
    }

    #[test]
    fn texture_edges_wrap_as_requested() {
        let texture = two_pixels();
        let cases = [(Wrap::Repeat, [0.5, 0.0, 1.0]), (Wrap::Clamp, [0.0, 1.0, 1.0]), (Wrap::Mirror, [0.0, 1.0, 0.0])];
        for (wrap, wanted) in cases {
            let found = [0.0, 1.25, 1.75].map(|u| grey(&texture, u, 0.0, wrap));
            assert!((0..3).all(|i| (found[i] - wanted[i]).abs() < 1e-6), "{wrap:?}: {found:?}");
        }
    }

    #[test]
    fn what_is_finer_than_the_picture_becomes_its_mean() {
        let pixels: Vec<u8> = (0..64 * 64).flat_map(|i| [255 * ((i + i / 64) % 2) as u8; 4]).collect();
        let texture = Texture::new(Image { width: 64, height: 64, rgba: pixels });
        assert!((grey(&texture, 0.3, 4.0 / 64.0, Wrap::Repeat) - 0.5).abs() < 1e-5);
        let first = texture.colour(Vec2::splat(0.5 / 64.0), [Vec2::ZERO; 2], [Wrap::Repeat; 2]);
        assert!(first.x < 1e-5, "{first}");
    }

    #[test]
    fn nothing_is_too_strange_to_be_sampled() {
        for u in [f32::NAN, f32::INFINITY, -1e30, 1e30] {
            let colour = two_pixels().colour(Vec2::new(u, u), [Vec2::splat(u); 2], [Wrap::Mirror, Wrap::Repeat]);
            assert!(colour.is_finite() || !u.is_finite() || u.abs() > 1e20, "{colour}");
        }
    }
}
