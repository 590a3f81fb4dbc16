//! Texels of all charts.

use glam::{DVec2, DVec3, Mat3, Vec3};

use super::fine::{FineSurface, SurfaceQuery};
use super::frames::Frames;
use super::texel::{Texel, TexelPlace, to_byte};
use super::unfold::Charts;
use crate::geometry::nearest_on_triangle::nearest_weights_f64;
use crate::geometry::triangle::{area_normal, corners_f64};
use crate::linalg::Rows;
use crate::mesh::{TriMesh, srgb};
use crate::parallel;

/// Distance in texels to which a border extends a chart; bilinear filtering reaches no farther.
const BORDER: f64 = 1.0;
/// Smallest cosine between a ray and its face; flatter rays use the face normal.
const STEEP: f32 = 0.2;
/// Smallest z of a direction in tangent space; below, viewers would see the back of the surface.
const RISE: f32 = 0.02;

struct Canvas<'a> {
    mesh: &'a TriMesh,
    charts: &'a Charts,
    frames: &'a Frames,
    fine: &'a FineSurface<'a>,
    // Faces that may touch each row.
    faces: Rows<u32>,
}

pub(super) fn draw_texels(mesh: &TriMesh, charts: &Charts, frames: &Frames, fine: &FineSurface) -> Vec<Texel> {
    let canvas = Canvas { mesh, charts, frames, fine, faces: rows(charts) };
    let mut texels = vec![Texel::default(); charts.size * charts.size];
    parallel::chunks_mut(&mut texels, charts.size, |row, line| canvas.draw_row(row, line));
    texels
}

fn rows(charts: &Charts) -> Rows<u32> {
    let size = charts.size as f64;
    let range = |face: usize| {
        let ys = charts.corners[face].map(|at| size - at.y);
        let [low, high] = [ys.iter().copied().fold(f64::INFINITY, f64::min), ys.iter().copied().fold(0.0, f64::max)];
        // Rows within the border belong to the face as well.
        let first = (low - 0.5 - BORDER).ceil().max(0.0) as usize;
        first..((high - 0.5 + BORDER).floor() + 1.0).clamp(0.0, size) as usize
    };
    let charted_faces = (0..charts.corners.len()).filter(|&face| charts.is_in_chart[face]);
    let entries = charted_faces.flat_map(|face| range(face).map(move |row| (row as u32, face as u32)));
    Rows::new(charts.size, entries)
}

impl Canvas<'_> {
    fn draw_row(&self, row: usize, line: &mut [Texel]) {
        let y = (self.charts.size - row) as f64 - 0.5;
        let faces = self.faces.row(row);
        for &face in faces {
            let corners = self.charts.corners[face as usize];
            let Some((low, high)) = crossing(corners, y) else { continue };
            for column in columns(low, high, line.len()) {
                let at = DVec2::new(column as f64 + 0.5, y);
                // Where charts overlap, the first face wins.
                if line[column].place == TexelPlace::Outside
                    && let Some(weights) = weights(corners, at)
                {
                    line[column] = self.texel(face, weights, TexelPlace::Inside);
                }
            }
        }
        self.draw_borders(y, faces, line);
    }

    fn draw_borders(&self, y: f64, faces: &[u32], line: &mut [Texel]) {
        let mut best: Vec<(f64, u32, [f64; 3])> = vec![(f64::INFINITY, u32::MAX, [0.0; 3]); line.len()];
        for &face in faces {
            let corners = self.charts.corners[face as usize];
            let xs = corners.map(|at| at.x);
            let low = xs.iter().copied().fold(f64::INFINITY, f64::min) - BORDER;
            let high = xs.iter().copied().fold(0.0, f64::max) + BORDER;
            for column in columns(low, high, line.len()).filter(|&column| line[column].place == TexelPlace::Outside) {
                let at = DVec3::new(column as f64 + 0.5, y, 0.0);
                let corners = corners.map(|corner| corner.extend(0.0));
                let weights = nearest_weights_f64(at, corners);
                let near = corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2];
                let distance = near.distance(at);
                // Several charts may reach a border texel: the nearest face wins.
                if distance <= BORDER && distance < best[column].0 {
                    best[column] = (distance, face, weights);
                }
            }
        }
        for (texel, (_, face, weights)) in line.iter_mut().zip(best).filter(|(_, (_, face, _))| *face != u32::MAX) {
            *texel = self.texel(face, weights, TexelPlace::Border);
        }
    }

    fn texel(&self, face: u32, weights: [f64; 3], place: TexelPlace) -> Texel {
        let corners = self.mesh.faces()[face as usize].map(|v| self.mesh.positions()[v as usize]);
        let points = corners_f64(corners);
        let point = points[0] * weights[0] + points[1] * weights[1] + points[2] * weights[2];
        let steps = steps(points, self.charts.corners[face as usize]);
        let weights = weights.map(|weight| weight as f32);
        let blend = |[a, b, c]: [Vec3; 3]| a * weights[0] + b * weights[1] + c * weights[2];
        let own = area_normal(corners.map(Vec3::from)).normalize_or_zero();
        let ray = blend(self.frames.rays[face as usize]).normalize_or_zero();
        // A common ray closes gaps at edges; a too flat ray is replaced by the face's own normal.
        let ray = if ray.dot(own) > STEEP || own == Vec3::ZERO { ray } else { own };
        let Some(answer) = self.fine.query(&SurfaceQuery { point, ray, normal: own, steps }) else {
            return Texel::default();
        };
        let normal = blend(self.frames.normals[face as usize]);
        let tangents = self.frames.tangents[face as usize];
        let tangent = blend(tangents.map(|tangent| tangent.truncate()));
        let direction = to_tangent_space(answer.normal, normal, tangent, tangents[0].w);
        let bytes = |colour: Vec3| colour.to_array().map(|x| to_byte(srgb(x.clamp(0.0, 1.0))));
        Texel {
            colour: bytes(answer.sample.colour),
            emission: bytes(answer.sample.emission),
            roughness: to_byte(answer.sample.roughness),
            metal: to_byte(answer.sample.metal),
            normal: direction.to_array().map(|x| to_byte(0.5 * x + 0.5)),
            place,
        }
    }
}

// Interpolated normals and tangents are not renormalised, as in MikkTSpace.
fn to_tangent_space(direction: Vec3, normal: Vec3, tangent: Vec3, sign: f32) -> Vec3 {
    let frame = Mat3::from_cols(tangent, sign * normal.cross(tangent), normal);
    let within = (frame.inverse() * direction).try_normalize().filter(|within| within.is_finite());
    let within = within.unwrap_or(Vec3::Z);
    // The limit applies in tangent space, where up is the mapped normal.
    within.with_z(within.z.max(RISE)).normalize()
}

fn steps(points: [DVec3; 3], corners: [DVec2; 3]) -> [DVec3; 2] {
    let (ab, ac) = (corners[1] - corners[0], corners[2] - corners[0]);
    let area = ab.perp_dot(ac);
    if area == 0.0 {
        return [DVec3::ZERO; 2];
    }
    let (pq, pr) = (points[1] - points[0], points[2] - points[0]);
    [(pq * ac.y - pr * ab.y) / area, (pq * ac.x - pr * ab.x) / area]
}

fn crossing(corners: [DVec2; 3], y: f64) -> Option<(f64, f64)> {
    let mut span: Option<(f64, f64)> = None;
    for i in 0..3 {
        let (a, b) = (corners[i], corners[(i + 1) % 3]);
        if (a.y <= y) == (b.y <= y) {
            continue;
        }
        let x = a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y));
        span = Some(span.map_or((x, x), |(low, high)| (low.min(x), high.max(x))));
    }
    span
}

fn columns(low: f64, high: f64, size: usize) -> std::ops::Range<usize> {
    let first = (low - 0.5).ceil().max(0.0) as usize;
    first..((high - 0.5).floor() + 1.0).clamp(0.0, size as f64) as usize
}

fn weights([a, b, c]: [DVec2; 3], at: DVec2) -> Option<[f64; 3]> {
    let area = (b - a).perp_dot(c - a);
    let v = (at - a).perp_dot(c - a) / area;
    let w = (b - a).perp_dot(at - a) / area;
    let [v, w] = [v, w].map(|x| x.clamp(0.0, 1.0));
    (area != 0.0).then_some([(1.0 - v - w).max(0.0), v, w])
}
