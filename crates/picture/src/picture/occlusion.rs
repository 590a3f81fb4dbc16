//! Ambient occlusion per pixel, from the z-buffer alone.
//!
//! After McGuire et al., "The Alchemy screen-space ambient obscurance algorithm" (2011).

use glam::Vec3;

use super::SAMPLES;
use super::camera::Camera;
use super::raster::{Buffer, NOTHING};
use super::shade::Face;
use crate::parallel;

const TAPS: usize = 40;
/// Largest distance of sampled points, as a share of the panel's height.
const REACH: f32 = 0.11;
/// Golden angle in radians, from one sampled point to the next.
const TURN: f32 = 2.399_963;

/// Place of pixels in which nothing is seen: takes no light, and its squared distances are finite.
const FAR: f32 = 1e18;
/// Pixels that are smoothed at a time.
const LANES: usize = 8;

/// Returns the share of ambient light at each pixel, 0 to 1, height x width.
pub fn openness(buffer: &Buffer, faces: &[Face], camera: &Camera) -> Vec<f32> {
    let seen = VisiblePoints::new(buffer, camera);
    let spiral = Spiral::new(REACH * camera.height as f32);
    // With the margin of the points, so that both are read at the same places.
    let mut raw = vec![1.0; seen.x.len()];
    let rows = &mut raw[seen.margin * seen.width..][..camera.height * seen.width];
    parallel::chunks_mut(rows, seen.width, |y, row| {
        for (x, open) in row[seen.margin..][..camera.width].iter_mut().enumerate() {
            let face = buffer.face[middle(buffer, x, y)];
            if face != NOTHING {
                *open = seen.pixel_openness(&spiral, faces[face as usize].normal, camera, x, y);
            }
        }
    });
    let mut smooth = vec![1.0; camera.width * camera.height];
    parallel::chunks_mut(&mut smooth, camera.width, |y, row| {
        for (chunk, open) in row.chunks_mut(LANES).enumerate() {
            seen.smooth_openness(&raw, camera, seen.index(chunk * LANES, y), open);
        }
    });
    smooth
}

// Sample in the middle of a pixel.
fn middle(buffer: &Buffer, x: usize, y: usize) -> usize {
    (y * SAMPLES + SAMPLES / 2) * buffer.width + x * SAMPLES + SAMPLES / 2
}

/// Visible points in the view's frame at the middles of pixels, with a margin in which nothing is seen.
struct VisiblePoints {
    // Pixels on each side, no fewer than sampled points are away.
    margin: usize,
    // Width in pixels, margins included.
    width: usize,
    x: Vec<f32>,
    y: Vec<f32>,
    z: Vec<f32>,
}

impl VisiblePoints {
    fn new(buffer: &Buffer, camera: &Camera) -> Self {
        let margin = LANES.max((REACH * camera.height as f32) as usize + 2);
        let width = camera.width + 2 * margin;
        let [x, y, z] = [(); 3].map(|()| vec![FAR; width * (camera.height + 2 * margin)]);
        let mut points = Self { margin, width, x, y, z };
        for row in 0..camera.height {
            for column in 0..camera.width {
                let sample = middle(buffer, column, row);
                if buffer.face[sample] != NOTHING {
                    let point = camera.unproject(column as f32 + 0.5, row as f32 + 0.5, buffer.near[sample]);
                    let at = points.index(column, row);
                    (points.x[at], points.y[at], points.z[at]) = point.into();
                }
            }
        }
        points
    }

    fn index(&self, x: usize, y: usize) -> usize {
        (y + self.margin) * self.width + x + self.margin
    }

    /// Returns the openness of a pixel from points on a spiral.
    fn pixel_openness(&self, spiral: &Spiral, normal: Vec3, camera: &Camera, x: usize, y: usize) -> f32 {
        let here = self.index(x, y);
        let here = Vec3::new(self.x[here], self.y[here], self.z[here]);
        let reach = REACH * camera.height as f32 / camera.scale;
        let mut hidden = [0.0; LANES];
        let places = spiral.places([x + self.margin, y + self.margin].map(|at| at as f32), noise(x, y), self.width);
        for places in places.as_chunks::<LANES>().0 {
            let [x, y, z] = [&self.x, &self.y, &self.z].map(|row| places.map(|at| row[at as usize]));
            for lane in 0..LANES {
                hidden[lane] += obscurance(normal, Vec3::new(x[lane], y[lane], z[lane]) - here, reach);
            }
        }
        (1.0 - 2.4 * hidden.iter().sum::<f32>() / TAPS as f32).clamp(0.0, 1.0)
    }

    /// Writes the mean of `raw` around each of the pixels from `first` in which something is seen.
    fn smooth_openness(&self, raw: &[f32], camera: &Camera, first: usize, open: &mut [f32]) {
        let take_lanes =
            |row: &[f32], at: usize| -> [f32; LANES] { std::array::from_fn(|lane| row[at..][..LANES][lane]) };
        let [x, y, z] = [&self.x, &self.y, &self.z].map(|row| take_lanes(row, first));
        if x.iter().all(|x| *x == FAR) {
            return;
        }
        // Pixels beyond a jump in depth belong to another surface.
        let most = (12.0 / camera.scale).powi(2);
        let (mut sum, mut weight) = ([0.0; LANES], [0.0; LANES]);
        for row in 0..7 {
            for column in 0..7 {
                let at = first + row * self.width + column - 3 * self.width - 3;
                let [near_x, near_y, near_z, raw] = [&self.x, &self.y, &self.z, raw].map(|row| take_lanes(row, at));
                for lane in 0..LANES {
                    let apart = [near_x[lane] - x[lane], near_y[lane] - y[lane], near_z[lane] - z[lane]];
                    let apart = apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2];
                    let share = if apart < most { 1.0 } else { 0.0 };
                    sum[lane] += share * raw[lane];
                    weight[lane] += share;
                }
            }
        }
        for (lane, open) in open.iter_mut().enumerate().filter(|(lane, _)| x[*lane] != FAR) {
            *open = sum[lane] / weight[lane];
        }
    }
}

/// Returns how much ambient light a point takes: the cosine above the horizon, fading with distance.
fn obscurance(normal: Vec3, toward: Vec3, reach: f32) -> f32 {
    let distance = toward.length().max(1e-3 * reach);
    let above = (normal.dot(toward) / distance - 0.08).max(0.0);
    let fade = 1.0 - (distance * (1.0 / (1.6 * reach))).min(1.0);
    above * fade
}

/// Offsets of sampled pixels from the pixel in the middle.
struct Spiral {
    x: [f32; TAPS],
    y: [f32; TAPS],
}

impl Spiral {
    fn new(reach: f32) -> Self {
        let radius = |tap: usize| reach * ((tap as f32 + 0.5) / TAPS as f32);
        let angle = |tap: usize| TURN * tap as f32;
        Self {
            x: std::array::from_fn(|tap| radius(tap) * angle(tap).cos()),
            y: std::array::from_fn(|tap| radius(tap) * angle(tap).sin()),
        }
    }

    /// Returns the indices of sampled pixels in rows of `width` around a place, for a turn from 0 to 1.
    ///
    /// The spiral is turned for each pixel, which trades bands for noise; smoothing removes the noise.
    fn places(&self, [x, y]: [f32; 2], turn: f32, width: usize) -> [u32; TAPS] {
        let (sin, cos) = (std::f32::consts::TAU * turn).sin_cos();
        let mut places = [0; TAPS];
        for ((place, dx), dy) in places.iter_mut().zip(&self.x).zip(&self.y) {
            let column = whole(x + cos * dx - sin * dy);
            let row = whole(y + sin * dx + cos * dy);
            *place = row * width as u32 + column;
        }
        places
    }
}

/// Returns the whole part of a number from 0.5 to 4 million, as the last bits of a float: a cast would not be vectorised.
fn whole(x: f32) -> u32 {
    const UNITS: f32 = 8_388_608.0;
    (x - 0.5 + UNITS).to_bits() - UNITS.to_bits()
}

/// Returns interleaved gradient noise (Jimenez 2014) from 0 to 1.
fn noise(x: usize, y: usize) -> f32 {
    (52.982_918 * (0.067_110_56 * x as f32 + 0.005_837_15 * y as f32).fract()).fract()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::picture::{raster, scaled_mesh, shade};

    /// Openness by the formulas, each sampled point with its own angle, each distance with its root.
    fn naive_openness(buffer: &Buffer, faces: &[Face], camera: &Camera) -> Vec<f32> {
        let (width, height) = (camera.width as isize, camera.height as isize);
        let see = |x: isize, y: isize| -> Option<(Vec3, Vec3)> {
            let inside = (0..width).contains(&x) && (0..height).contains(&y);
            let sample = inside.then(|| middle(buffer, x as usize, y as usize))?;
            let face = faces.get(buffer.face[sample] as usize)?;
            Some((camera.unproject(x as f32 + 0.5, y as f32 + 0.5, buffer.near[sample]), face.normal))
        };
        let reach = REACH * camera.height as f32;
        let raw = |x: isize, y: isize| -> Option<f32> {
            let (here, normal) = see(x, y)?;
            let hidden = (0..TAPS).map(|tap| {
                let radius = reach * (tap as f32 + 0.5) / TAPS as f32;
                let angle = std::f32::consts::TAU * noise(x as usize, y as usize) + TURN * tap as f32;
                let there = [x as f32 + radius * angle.cos(), y as f32 + radius * angle.sin()];
                let [there_x, there_y] = there.map(|at| at.floor() as isize);
                let world_reach = reach / camera.scale;
                see(there_x, there_y).map_or(0.0, |(there, _)| obscurance(normal, there - here, world_reach))
            });
            Some((1.0 - 2.4 * hidden.sum::<f32>() / TAPS as f32).clamp(0.0, 1.0))
        };
        let smooth = |x: isize, y: isize| -> Option<f32> {
            let (here, _) = see(x, y)?;
            let window = (y - 3..=y + 3).flat_map(|y| (x - 3..=x + 3).map(move |x| (x, y)));
            let same_surface = |x, y| see(x, y).is_some_and(|(p, _)| here.distance(p) * camera.scale < 12.0);
            let near: Vec<f32> = window.filter(|&(x, y)| same_surface(x, y)).filter_map(|(x, y)| raw(x, y)).collect();
            Some(near.iter().sum::<f32>() / near.len() as f32)
        };
        (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| smooth(x, y).unwrap_or(1.0)).collect()
    }

    #[test]
    fn lanes_agree_with_the_formulas() {
        let ball = shapes::icosphere(3);
        let mesh = shapes::unite([ball.clone(), shapes::place(&ball, |[x, y, z]| [x + 0.9, y + 0.9, z])]);
        let shapes = scaled_mesh::scale_meshes(&[&mesh]);
        let camera = Camera::with_best_view(&shapes, 66);
        let points = camera.project(&shapes[0].points);
        let buffer = raster::draw(&points, shapes[0].faces, camera.width * SAMPLES, camera.height * SAMPLES);
        let faces = shade::faces(&shapes[0], &camera, false, false);
        let [fast, naive] = [openness(&buffer, &faces, &camera), naive_openness(&buffer, &faces, &camera)];
        let n_dark = naive.iter().filter(|open| **open < 0.95).count();
        assert!(n_dark > 200, "{n_dark} of {}", naive.len());
        // A sampled point at the border of two pixels may be in either.
        let off: Vec<f32> = fast.iter().zip(&naive).map(|(a, b)| (a - b).abs()).filter(|off| *off > 1e-5).collect();
        assert!(off.len() * 100 < naive.len() && off.iter().all(|off| *off < 0.02), "{} {off:?}", off.len());
    }
}
