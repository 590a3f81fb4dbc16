//! Rings that mark points in a picture.

use glam::{Vec2, Vec3};

use super::Image;

/// Radius of the ring as a share of the panel's height.
const RADIUS: f32 = 0.028;
// Half width of the line, and of the light rim around it, in pixels.
const LINE: f32 = 1.2;
const RIM: f32 = 2.4;
// Colours, sRGB, unlikely to occur in meshes.
const INK: [u8; 3] = [214, 24, 120];
const LIGHT: [u8; 3] = [255, 255, 255];

/// Draws a ring around `place`, a point in pixels.
pub fn ring(image: &mut Image, place: Vec3) {
    let radius = RADIUS * image.height as f32;
    let reach = radius + RIM + 1.0;
    let range = |middle: f32, n: usize| {
        let [low, high] = [middle - reach, middle + reach].map(|x| x.clamp(0.0, n as f32) as usize);
        low..n.min(high + 1)
    };
    for y in range(place.y, image.height) {
        for x in range(place.x, image.width) {
            let off = (Vec2::new(x as f32 + 0.5, y as f32 + 0.5).distance(place.truncate()) - radius).abs();
            let at = 4 * (y * image.width + x);
            let Some(pixel) = image.rgba.get_mut(at..at + 3) else { continue };
            blend(pixel, LIGHT, 0.7 * cover(off, RIM));
            blend(pixel, INK, cover(off, LINE));
        }
    }
}

fn cover(off: f32, half_width: f32) -> f32 {
    (half_width + 0.5 - off).clamp(0.0, 1.0)
}

fn blend(pixel: &mut [u8], ink: [u8; 3], cover: f32) {
    for (channel, ink) in pixel.iter_mut().zip(ink) {
        *channel = (f32::from(*channel) * (1.0 - cover) + f32::from(ink) * cover).round() as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ring_stands_around_its_place_and_is_cut_off_at_the_edge() {
        let grey = || Image { width: 800, height: 400, rgba: vec![128; 800 * 400 * 4] };
        let red = |image: &Image, x: usize, y: usize| image.rgba[4 * (y * image.width + x)];
        let mut image = grey();
        ring(&mut image, Vec3::new(50.5, 50.5, 1.0));
        let radius = (RADIUS * 400.0).round() as usize;
        assert_eq!(red(&image, 50, 50), 128);
        assert!(red(&image, 50 + radius, 50) > 180 && red(&image, 50, 50 - radius) > 180);
        for outside in [[-500.0, 3.0], [799.9, 399.9], [1e30, -1e30], [f32::NAN, 5.0]] {
            let mut image = grey();
            ring(&mut image, Vec3::new(outside[0], outside[1], 1.0));
            assert_eq!(image.rgba.len(), grey().rgba.len());
        }
    }
}
