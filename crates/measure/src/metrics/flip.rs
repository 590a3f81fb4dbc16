//! FLIP: the difference that a viewer sees on flipping between two pictures (Andersson et al. 2020).

use crate::mesh::linear_light;
use glam::{DMat3, DVec3};
use std::f64::consts::PI;

/// Pixels per degree of view: a screen of 3840 pixels and 0.7 m width seen from 0.7 m, as in the paper.
const PIXELS_PER_DEGREE: f64 = 67.020_643_276_582_25;
/// Contrast sensitivity of luminance, red-green, blue-yellow as sums of two Gaussians: `a1, b1, a2, b2` of Table 1.
const SENSITIVITY: [[f64; 4]; 3] = [[1.0, 0.0047, 0.0, 1e-5], [1.0, 0.0053, 0.0, 1e-5], [34.1, 0.04, 13.5, 0.025]];
/// Exponent of colour differences.
const COLOUR_EXPONENT: f64 = 0.7;
/// Colour difference, as a share of the largest, that is mapped to `COLOUR_MAPPED`; larger ones fill the range to 1.
const COLOUR_SHARE: f64 = 0.4;
const COLOUR_MAPPED: f64 = 0.95;
/// Width of detected edges and points in degrees of view.
const FEATURE_WIDTH: f64 = 0.082;
/// Exponent of feature differences.
const FEATURE_EXPONENT: f64 = 0.5;
/// Matrix from linear sRGB to XYZ.
const XYZ: [[f64; 3]; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];

/// Returns the FLIP error of each pixel of two sRGB pictures, 0 if equal, at most 1.
///
/// At 67 pixels per degree of view. `None` if the sizes differ or there are no pixels.
///
/// # Shapes
/// - `a`, `b`: width x height pixels, row by row
///
/// ```
/// # use neural_mesh_measure as neural_mesh;
/// use neural_mesh::metrics::flip;
/// let (black, white) = ([[0; 3]; 64], [[255; 3]; 64]);
/// assert_eq!(flip(8, &black, &black), Some(vec![0.0; 64]));
/// assert!(flip(8, &black, &white).unwrap().iter().all(|error| *error > 0.9));
/// ```
pub fn flip(width: usize, a: &[[u8; 3]], b: &[[u8; 3]]) -> Option<Vec<f64>> {
    if a.is_empty() || a.len() != b.len() || width == 0 || !a.len().is_multiple_of(width) {
        return None;
    }
    let light: [f64; 256] = std::array::from_fn(|byte| f64::from(linear_light(byte as f32 / 255.0)));
    let pictures = [a, b].map(|pixels| {
        let opponent = pixels.iter().map(|pixel| to_opponent(pixel.map(|byte| light[usize::from(byte)]))).collect();
        Picture { width, opponent }
    });
    let [filtered_a, filtered_b] = [&pictures[0], &pictures[1]].map(Picture::to_perceived_lab);
    let [features_a, features_b] = [&pictures[0], &pictures[1]].map(Picture::features);
    let largest = largest_difference();
    let pixel = |at: usize| {
        let colour = map_colour_difference(hyab(filtered_a[at], filtered_b[at]).powf(COLOUR_EXPONENT), largest);
        let [edges, points] = [0, 1].map(|kind| (features_a[kind][at] - features_b[kind][at]).abs());
        let feature = (edges.max(points) / 2f64.sqrt()).powf(FEATURE_EXPONENT).min(1.0);
        colour.powf(1.0 - feature)
    };
    Some((0..a.len()).map(pixel).collect())
}

/// A picture in YCxCz, which separates luminance, red-green and blue-yellow.
struct Picture {
    width: usize,
    opponent: Vec<[f64; 3]>,
}

impl Picture {
    /// Blurs as the eye does at this distance; returns Hunt-adjusted L*a*b* of each pixel.
    fn to_perceived_lab(&self) -> Vec<[f64; 3]> {
        let largest_spread = SENSITIVITY.iter().map(|channel| channel[1]).fold(0.0, f64::max);
        let radius = (3.0 * (largest_spread / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as isize;
        let channels: [Vec<f64>; 3] = std::array::from_fn(|channel| {
            let values: Vec<f64> = self.opponent.iter().map(|pixel| pixel[channel]).collect();
            let [a1, b1, a2, b2] = SENSITIVITY[channel];
            let (mut sum, mut weights) = (vec![0.0; values.len()], 0.0);
            for [a, b] in [[a1, b1], [a2, b2]] {
                if a == 0.0 {
                    continue;
                }
                let kernel: Vec<f64> =
                    (-radius..=radius).map(|x| (-PI * PI * (x as f64 / PIXELS_PER_DEGREE).powi(2) / b).exp()).collect();
                let weight = a * (PI / b).sqrt();
                weights += weight * kernel.iter().sum::<f64>().powi(2);
                let blurred = convolve(&values, self.width, &kernel, &kernel);
                sum.iter_mut().zip(blurred).for_each(|(sum, value)| *sum += weight * value);
            }
            sum.into_iter().map(|value| value / weights).collect()
        });
        let [y, cx, cz] = channels;
        let to_linear = DMat3::from_cols_array_2d(&XYZ).transpose().inverse();
        // Pixels of a plain background repeat, and cube roots are slow.
        let (mut last, mut seen) = ([f64::NAN; 3], [0.0; 3]);
        let lab = |((y, cx), cz)| {
            if last != [y, cx, cz] {
                last = [y, cx, cz];
                seen = to_hunt_lab(opponent_to_linear(&to_linear, last));
            }
            seen
        };
        y.into_iter().zip(cx).zip(cz).map(lab).collect()
    }

    /// Returns the strength of edges and of points at each pixel.
    fn features(&self) -> [Vec<f64>; 2] {
        let luminance: Vec<f64> = self.opponent.iter().map(|pixel| (pixel[0] + 16.0) / 116.0).collect();
        let spread = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
        let radius = (3.0 * spread).ceil() as isize;
        let gaussian = |x: isize| (-(x * x) as f64 / (2.0 * spread * spread)).exp();
        let across = normalized_by_sign((-radius..=radius).map(gaussian).collect());
        let edges = |x: isize| -x as f64 * gaussian(x);
        let points = |x: isize| ((x * x) as f64 / (spread * spread) - 1.0) * gaussian(x);
        [(-radius..=radius).map(edges).collect(), (-radius..=radius).map(points).collect()].map(|along| {
            let along = normalized_by_sign(along);
            let x = convolve(&luminance, self.width, &along, &across);
            let y = convolve(&luminance, self.width, &across, &along);
            x.into_iter().zip(y).map(|(x, y)| x.hypot(y)).collect()
        })
    }
}

/// Scales positive weights to a sum of 1 and negative ones to -1.
fn normalized_by_sign(kernel: Vec<f64>) -> Vec<f64> {
    let positive: f64 = kernel.iter().filter(|weight| **weight > 0.0).sum();
    let negative: f64 = -kernel.iter().filter(|weight| **weight < 0.0).sum::<f64>();
    kernel
        .into_iter()
        .map(|weight| if weight > 0.0 { weight / positive } else { weight / negative.max(f64::MIN_POSITIVE) })
        .collect()
}

/// Convolves rows by `along` and columns by `across`; pixels outside repeat the border.
fn convolve(values: &[f64], width: usize, along: &[f64], across: &[f64]) -> Vec<f64> {
    let n_beyond = along.len() / 2;
    let mut padded = vec![0.0; width + 2 * n_beyond];
    let mut rows = vec![0.0; values.len()];
    for (row, sums) in values.chunks_exact(width).zip(rows.chunks_exact_mut(width)) {
        padded[..n_beyond].fill(row[0]);
        padded[n_beyond..][..width].copy_from_slice(row);
        padded[n_beyond + width..].fill(row[width - 1]);
        // Convolution reverses the kernel.
        for (offset, weight) in along.iter().rev().enumerate() {
            add_scaled(sums, *weight, &padded[offset..]);
        }
    }
    let last = values.len() / width - 1;
    let mut sums = vec![0.0; values.len()];
    for (row, sums) in sums.chunks_exact_mut(width).enumerate() {
        for (offset, weight) in across.iter().rev().enumerate() {
            let near = (row + offset).saturating_sub(across.len() / 2).min(last);
            add_scaled(sums, *weight, &rows[near * width..]);
        }
    }
    sums
}

fn add_scaled(sums: &mut [f64], weight: f64, values: &[f64]) {
    sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
}

/// Converts linear sRGB to YCxCz.
fn to_opponent(linear: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = to_relative_xyz(linear);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Converts YCxCz to linear sRGB, clamped to 0..=1; `to_linear` is the inverse of [`XYZ`].
fn opponent_to_linear(to_linear: &DMat3, [y, cx, cz]: [f64; 3]) -> [f64; 3] {
    let y = (y + 16.0) / 116.0;
    let relative = [y + cx / 500.0, y, y - cz / 200.0];
    let xyz = DVec3::from_array([0, 1, 2].map(|k| relative[k] * XYZ[k].iter().sum::<f64>()));
    (*to_linear * xyz).to_array().map(|value| value.clamp(0.0, 1.0))
}

/// Converts linear sRGB to XYZ, divided by the XYZ of white.
fn to_relative_xyz(linear: [f64; 3]) -> [f64; 3] {
    XYZ.map(|row| row.iter().zip(linear).map(|(weight, value)| weight * value).sum::<f64>() / row.iter().sum::<f64>())
}

/// Returns L*a*b* with a* and b* scaled by the lightness: differences of dark colours count less (Hunt effect).
fn to_hunt_lab(linear: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = to_relative_xyz(linear).map(|value| {
        let knee: f64 = 6.0 / 29.0;
        if value > knee.powi(3) { value.cbrt() } else { value / (3.0 * knee * knee) + 4.0 / 29.0 }
    });
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
}

/// Returns the HyAB distance: that of the lightness plus that in the plane of a* and b*.
fn hyab(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

/// Returns the largest colour difference, that of pure green and blue.
fn largest_difference() -> f64 {
    hyab(to_hunt_lab([0.0, 1.0, 0.0]), to_hunt_lab([0.0, 0.0, 1.0])).powf(COLOUR_EXPONENT)
}

/// Maps a colour difference to 0..=1: small ones over most of the range, large ones compressed.
fn map_colour_difference(difference: f64, largest: f64) -> f64 {
    let knee = COLOUR_SHARE * largest;
    if difference < knee {
        return COLOUR_MAPPED / knee * difference;
    }
    COLOUR_MAPPED + (difference - knee) / (largest - knee) * (1.0 - COLOUR_MAPPED)
}

#[cfg(test)]
mod tests {
    use super::flip;

    /// A picture of bars, a ramp and a few bright points.
    fn picture(shift: usize) -> Vec<[u8; 3]> {
        let pixel = |at: usize| {
            let (x, y) = (at % 48 + shift, at / 48);
            let bar = if x / 6 % 2 == 0 { 200 } else { 40 };
            let point = if (x * 7 + y * 13).is_multiple_of(61) { 255 } else { 0 };
            [bar.max(point), (5 * y) as u8, (x * 4).min(255) as u8]
        };
        (0..48 * 40).map(pixel).collect()
    }

    fn mean_flip(a: &[[u8; 3]], b: &[[u8; 3]]) -> f64 {
        let errors = flip(48, a, b).unwrap();
        errors.iter().sum::<f64>() / errors.len() as f64
    }

    #[test]
    fn agrees_with_the_authors_implementation() {
        // By `flip_evaluator` 1.7 (NVIDIA) in single precision.
        for (shift, expected) in [(1, 0.277_667), (3, 0.541_837), (6, 0.697_674)] {
            let value = mean_flip(&picture(0), &picture(shift));
            assert!((value - expected).abs() < 2e-5, "{shift}: {value}");
        }
        let value = mean_flip(&picture(0), &[[128; 3]; 48 * 40]);
        assert!((value - 0.767_342).abs() < 2e-5, "{value}");
    }

    #[test]
    fn is_symmetric_and_needs_pictures_of_one_size() {
        let (a, b) = (picture(0), picture(2));
        let [there, back] = [mean_flip(&a, &b), mean_flip(&b, &a)];
        assert!((there - back).abs() < 1e-12 && there > 0.0);
        assert!([flip(48, &a, &b[48..]), flip(7, &a, &b), flip(0, &[], &[])].iter().all(Option::is_none));
    }
}
