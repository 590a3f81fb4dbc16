//! Ambient occlusion per pixel, from the z-buffer alone.
//!
//! After McGuire et al., "The Alchemy screen-space ambient obscurance algorithm" (2011).

use glam::Vec3;
use rayon::prelude::*;

use super::SAMPLES;
use super::camera::Camera;
use super::raster::{Buffer, NOTHING};
use super::shade::Face;

const TAPS: usize = 40;
/// Largest distance of sampled points, as a share of the panel's height.
const REACH: f32 = 0.11;
/// Golden angle in radians, from one sampled point to the next.
const TURN: f32 = 2.399_963;

#[derive(Clone, Copy)]
struct VisiblePoint {
    at: Vec3,
    // Normal in the view's frame, turned to the eye.
    normal: Vec3,
}

/// Returns the share of ambient light at each pixel, 0 to 1, height x width.
pub fn openness(buffer: &Buffer, faces: &[Face], camera: &Camera) -> Vec<f32> {
    let seen = middles(buffer, faces, camera);
    let raw = per_pixel(camera, |x, y| pixel_openness(&seen, camera, x, y));
    per_pixel(camera, |x, y| smooth_openness(&raw, &seen, camera, x, y))
}

fn per_pixel<T: Send>(camera: &Camera, value: impl Fn(usize, usize) -> T + Sync) -> Vec<T> {
    let n_pixels = camera.width * camera.height;
    (0..n_pixels)
        .into_par_iter()
        .with_min_len(camera.width)
        .map(|at| value(at % camera.width, at / camera.width))
        .collect()
}

fn middles(buffer: &Buffer, faces: &[Face], camera: &Camera) -> Vec<Option<VisiblePoint>> {
    per_pixel(camera, |x, y| {
        let sample = (y * SAMPLES + SAMPLES / 2) * buffer.width + x * SAMPLES + SAMPLES / 2;
        let face = buffer.face[sample];
        (face != NOTHING).then(|| VisiblePoint {
            at: camera.unproject(x as f32 + 0.5, y as f32 + 0.5, buffer.near[sample]),
            normal: faces[face as usize].normal,
        })
    })
}

/// Returns the openness of a pixel from points on a spiral.
fn pixel_openness(seen: &[Option<VisiblePoint>], camera: &Camera, x: usize, y: usize) -> f32 {
    let Some(here) = seen[y * camera.width + x] else { return 1.0 };
    let reach = REACH * camera.height as f32;
    let world_reach = reach / camera.scale;
    // The spiral is turned for each pixel, which trades bands for noise; smoothing removes the noise.
    let start = std::f32::consts::TAU * noise(x, y);
    let mut hidden = 0.0;
    for tap in 0..TAPS {
        let radius = reach * ((tap as f32 + 0.5) / TAPS as f32);
        let (sin, cos) = (start + TURN * tap as f32).sin_cos();
        let (there_x, there_y) = (x as f32 + radius * cos, y as f32 + radius * sin);
        let inside =
            there_x >= 0.0 && there_y >= 0.0 && there_x < camera.width as f32 && there_y < camera.height as f32;
        let there = if inside { seen[there_y as usize * camera.width + there_x as usize] } else { None };
        hidden += there.map_or(0.0, |there| obscurance(here, there.at, world_reach));
    }
    (1.0 - 2.4 * hidden / TAPS as f32).clamp(0.0, 1.0)
}

/// Returns how much ambient light `there` takes from `here`: the cosine above the horizon, fading with distance.
fn obscurance(here: VisiblePoint, there: Vec3, reach: f32) -> f32 {
    let toward = there - here.at;
    let distance = toward.length().max(1e-3 * reach);
    let above = (here.normal.dot(toward) / distance - 0.08).max(0.0);
    let fade = 1.0 - (distance / (1.6 * reach)).min(1.0);
    above * fade
}

fn smooth_openness(raw: &[f32], seen: &[Option<VisiblePoint>], camera: &Camera, x: usize, y: usize) -> f32 {
    let Some(here) = seen[y * camera.width + x] else { return 1.0 };
    let (mut sum, mut weight) = (0.0, 0.0);
    for near_y in y.saturating_sub(3)..(y + 4).min(camera.height) {
        for near_x in x.saturating_sub(3)..(x + 4).min(camera.width) {
            let at = near_y * camera.width + near_x;
            let apart = seen[at].map_or(f32::INFINITY, |there| (there.at - here.at).length() * camera.scale);
            // Pixels beyond a jump in depth belong to another surface.
            let share = if apart < 12.0 { 1.0 } else { 0.0 };
            sum += share * raw[at];
            weight += share;
        }
    }
    sum / weight
}

/// Returns interleaved gradient noise (Jimenez 2014) from 0 to 1.
fn noise(x: usize, y: usize) -> f32 {
    (52.982_918 * (0.067_110_56 * x as f32 + 0.005_837_15 * y as f32).fract()).fract()
}
