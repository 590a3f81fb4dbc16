//! Light and colour of faces or samples, averaged to pixels.

use glam::{Vec2, Vec3};

use super::camera::Camera;
use super::corner_normals::BlendedNormals;
use super::pixels::to_srgb;
use super::raster::{Buffer, NOTHING};
use super::scaled_mesh::ScaledMesh;
use super::surface_materials::PlacedMaterials;
use super::value_paint::ValuePaint;
use super::{Image, SAMPLES};
use crate::parallel;

// Colours in linear light.
const FRONT: Vec3 = Vec3::new(0.50, 0.58, 0.68);
// Share of a mesh's own colours that is reflected.
const PAINTED: Vec3 = Vec3::splat(0.78);
const BACK: Vec3 = Vec3::new(0.72, 0.20, 0.14);
const LINE: Vec3 = Vec3::new(0.012, 0.022, 0.045);
const SKY: Vec3 = Vec3::new(0.97, 0.975, 0.985);
const GROUND: Vec3 = Vec3::new(0.83, 0.85, 0.88);

// Direction (view's frame) and colour of the lights: warm from the upper left in front, cool and weak from the right.
const KEY: [Vec3; 2] = [Vec3::new(-0.52, 0.62, 0.59), Vec3::new(1.06, 1.0, 0.92)];
const FILL: [Vec3; 2] = [Vec3::new(0.84, -0.08, 0.54), Vec3::new(0.20, 0.24, 0.30)];

const LINE_STRENGTH: f32 = 0.62;
// Sizes of a face (square root of twice its area, in pixels) between which lines fade in; on smaller faces they only
// darken.
const LINE_SIZES: [f32; 2] = [2.0, 11.0];
// Median face sizes, by area, between which all lines of a mesh fade in; otherwise they would appear in patches.
const MESH_LINE_SIZES: [f32; 2] = [3.5, 7.5];

/// Shading of a face.
pub struct Face {
    // Unit normal in the view's frame, turned to the eye; zero without area.
    pub normal: Vec3,
    direct: Vec3,
    ambient: Vec3,
    colour: Vec3,
    // 1 if the front is visible, else -1.
    side: f32,
    // Darkness of the edges, 0 to 1.
    line: f32,
}

pub fn faces(shape: &ScaledMesh, camera: &Camera, edges: bool, painted: bool) -> Vec<Face> {
    let front = if painted { PAINTED } else { FRONT };
    let normals = shape.area_normals();
    let sizes: Vec<f32> = normals.iter().map(|normal| camera.scale * normal.length().sqrt()).collect();
    // Lines of dense meshes would only darken them, so they fade as a whole.
    let strength = if edges { LINE_STRENGTH * fade(usual_size(&sizes), MESH_LINE_SIZES) } else { 0.0 };
    parallel::map(normals.len(), 1024, |face| {
        let toward = camera.eye() - camera.view(shape.points[shape.faces[face][0] as usize]);
        let line = strength * fade(sizes[face], LINE_SIZES);
        shade_face(camera.view(normals[face].normalize_or_zero()), toward, front, line)
    })
}

// The size divides the surface into halves of equal area.
fn usual_size(sizes: &[f32]) -> f32 {
    let mut sorted = sizes.to_vec();
    sorted.sort_unstable_by(f32::total_cmp);
    let area = |size: &f32| f64::from(*size).powi(2);
    let half = 0.5 * sorted.iter().map(area).sum::<f64>();
    let mut below = 0.0;
    let usual = sorted.iter().find(|size| {
        below += area(size);
        below >= half
    });
    usual.copied().unwrap_or(0.0)
}

fn shade_face(outward: Vec3, toward: Vec3, front: Vec3, line: f32) -> Face {
    let seen_from_front = outward.dot(toward) >= 0.0;
    let (side, colour) = if seen_from_front { (1.0, front) } else { (-1.0, BACK) };
    let normal = outward * side;
    let [direct, ambient] = light(normal, colour);
    Face { normal, direct, ambient, colour, side, line }
}

// Direct and ambient light that a surface of this colour and unit normal reflects.
fn light(normal: Vec3, colour: Vec3) -> [Vec3; 2] {
    let [key, fill] = [KEY, FILL].map(|[from, light]| light * normal.dot(from.normalize()).max(0.0));
    let sky = 0.5 + 0.5 * normal.y;
    let ambient = Vec3::new(0.20, 0.22, 0.27).lerp(Vec3::new(0.38, 0.39, 0.41), sky);
    [colour * (key + fill) * 0.98, colour * ambient]
}

impl Face {
    /// Returns the stored normal turned to the eye, or that of the face if the stored one is zero.
    pub fn shading_normal(&self, stored: Vec3) -> Vec3 {
        if stored == Vec3::ZERO { self.normal } else { stored * self.side }
    }
}

fn fade(size: f32, [none, full]: [f32; 2]) -> f32 {
    let t = ((size - none) / (full - none)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Colours and normals on the faces of a mesh in a picture.
#[derive(Default)]
pub struct Shading<'a> {
    // Colours that multiply the light; white by default.
    pub paint: Option<Paint<'a>>,
    // Stored normals; those of the faces by default.
    pub normals: Option<BlendedNormals<'a>>,
}

pub enum Paint<'a> {
    Materials(PlacedMaterials<'a>),
    Values(ValuePaint<'a>),
}

impl Shading<'_> {
    fn colour(&self, face: u32, at: Vec2) -> Vec3 {
        match &self.paint {
            None => Vec3::ONE,
            Some(Paint::Materials(materials)) => materials.colour(face, at),
            Some(Paint::Values(values)) => values.colour(face, at),
        }
    }

    /// Returns the stored normal of a face at a point in sample coordinates; zero if it has none.
    pub fn normal(&self, face: u32, at: Vec2) -> Vec3 {
        self.normals.as_ref().map_or(Vec3::ZERO, |normals| normals.normal(face, at))
    }
}

/// Lights the samples and averages them by pixel; `open` is the share of ambient light per pixel.
pub fn resolve(buffer: &Buffer, faces: &[Face], open: &[f32], camera: &Camera, shading: &Shading) -> Image {
    let look = ShadedView { buffer, faces, shading };
    let mut rgba = vec![255; camera.width * camera.height * 4];
    parallel::chunks_mut(&mut rgba, camera.width * 4, |row, line| {
        let behind = background_light(row as f32 / camera.height as f32);
        // Colours repeat along a row where nothing is seen, and their curve is slow.
        let (mut last, mut encoded) = (behind, to_srgb(behind));
        for (column, pixel) in line.chunks_exact_mut(4).enumerate() {
            let colour = look.pixel(open[row * camera.width + column], [column, row], behind);
            if colour != last {
                (last, encoded) = (colour, to_srgb(colour));
            }
            pixel.copy_from_slice(&encoded);
        }
    });
    Image { width: camera.width, height: camera.height, rgba }
}

struct ShadedView<'a> {
    buffer: &'a Buffer,
    faces: &'a [Face],
    shading: &'a Shading<'a>,
}

impl ShadedView<'_> {
    fn pixel(&self, open: f32, [column, row]: [usize; 2], behind: Vec3) -> Vec3 {
        let mut sum = Vec3::ZERO;
        for y in row * SAMPLES..(row + 1) * SAMPLES {
            for x in column * SAMPLES..(column + 1) * SAMPLES {
                sum += self.sample([x, y], open).unwrap_or(behind);
            }
        }
        sum / (SAMPLES * SAMPLES) as f32
    }

    fn sample(&self, [x, y]: [usize; 2], open: f32) -> Option<Vec3> {
        let at = y * self.buffer.width + x;
        let face = self.buffer.face[at];
        if face == NOTHING {
            return None;
        }
        let middle = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
        let look = &self.faces[face as usize];
        // A stored normal changes the light of each sample; a face normal is lit once.
        let stored = self.shading.normal(face, middle);
        let [direct, ambient] = if stored == Vec3::ZERO {
            [look.direct, look.ambient]
        } else {
            light(look.shading_normal(stored), look.colour)
        };
        // Corners lose all ambient light and a part of the direct light.
        let lit = ambient * open + direct * (0.35 + 0.65 * open);
        let colour = lit.lerp(LINE, look.line * f32::from(self.buffer.line[at]) / 255.0);
        Some(colour * self.shading.colour(face, middle))
    }
}

fn background_light(down: f32) -> Vec3 {
    SKY.lerp(GROUND, down)
}

pub fn background(down: f32) -> [u8; 4] {
    to_srgb(background_light(down))
}
