//! Least squares of the output vertices to the original surface.
//!
//! A vertex at the minimum of its tangent planes lies too far inside a curved surface for the triangles around it
//! to cut the surface. So centroids of input faces are sent to the nearest output face, and the output vertices
//! move toward where the weighted squared distances along the faces' normals are smallest: each in the direction of
//! its own 3 x 3 system, all by the length that is best for them together. A step that turns a face or does not pay
//! is not taken.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::geometry::triangle::{area_normal, nearest_weights};

use super::surface::Surface;

/// Input faces looked at per output vertex, at most.
const POINTS_PER_VERTEX: usize = 14;
/// Weight of staying in place against the points.
const STAY: f64 = 0.01;
/// Least cosine between a face's normal before and after a step.
const LEAST_COSINE: f32 = 0.7;

/// The output mesh as the fit moves it.
pub(super) struct Output<'a> {
    /// Normalised positions, n_vertices x 3.
    pub positions: &'a mut [Vec3],
    /// Faces, n_faces x 3.
    pub faces: &'a [[u32; 3]],
    /// For each input vertex the output vertex that its region became.
    pub vertex_of: &'a [u32],
}

/// A point of the original and the nearest point of the output.
struct Match {
    face: u32,
    weights: [f32; 3],
    area: f32,
    point: Vec3,
    /// From the output point to the original one.
    gap: Vec3,
}

/// Moves the output vertices toward the original surface once.
pub(super) fn fit(surface: &Surface, output: &mut Output) {
    let around = FacesAround::new(output.positions.len(), output.faces);
    let normals = normals(output);
    let stride = (surface.faces.len() / (POINTS_PER_VERTEX * output.positions.len()).max(1)).max(1);
    let chosen = surface.faces.par_chunks(stride).map(|chunk| chunk[0]);
    let matches: Vec<Match> =
        chosen.filter_map(|face| nearest_output(surface, output, &around, &normals, face)).collect();
    let steps = solve(output, &normals, &matches);
    let before = output.positions.to_vec();
    take_steps(output, &around, &steps);
    undo_what_does_not_pay(output, &matches, &before);
}

/// Unit normals of the output faces.
fn normals(output: &Output) -> Vec<Vec3> {
    let normal = |face: &[u32; 3]| area_normal(face.map(|v| output.positions[v as usize])).normalize_or_zero();
    output.faces.par_iter().map(normal).collect()
}

/// The output point nearest to the centroid of an input face, found by walking downhill from its first corner's vertex.
fn nearest_output(
    surface: &Surface,
    output: &Output,
    around: &FacesAround,
    normals: &[Vec3],
    face: [u32; 3],
) -> Option<Match> {
    let corners = face.map(|v| surface.positions[v as usize]);
    let normal = area_normal(corners);
    let target = Target { output, normals, point: (corners[0] + corners[1] + corners[2]) / 3.0, normal };
    let mut best: Option<Reach> = None;
    for &f in around.faces(output.vertex_of[face[0] as usize]) {
        let limit = best.as_ref().map_or(f32::INFINITY, |b| b.distance);
        best = target.reach(f, limit).or(best);
    }
    let mut best = best?;
    while let Some(closer) = target.step(around, &best) {
        best = closer;
    }
    let Reach { face, weights, gap, .. } = best;
    Some(Match { face, weights, area: 0.5 * normal.length(), point: target.point, gap })
}

/// A point that looks for its place on the output.
struct Target<'a> {
    output: &'a Output<'a>,
    normals: &'a [Vec3],
    point: Vec3,
    normal: Vec3,
}

/// The nearest point of one face.
struct Reach {
    face: u32,
    weights: [f32; 3],
    gap: Vec3,
    distance: f32,
}

impl Target<'_> {
    /// The nearest point of `face` if it looks the same way and is nearer than `limit` (squared).
    fn reach(&self, face: u32, limit: f32) -> Option<Reach> {
        if self.normals[face as usize].dot(self.normal) <= 0.0 {
            return None;
        }
        let triangle = self.output.faces[face as usize].map(|v| self.output.positions[v as usize]);
        let weights = nearest_weights(self.point, triangle);
        let gap = self.point - (triangle[0] * weights[0] + triangle[1] * weights[1] + triangle[2] * weights[2]);
        let distance = gap.length_squared();
        (distance < limit).then_some(Reach { face, weights, gap, distance })
    }

    /// A face beyond the edge or vertex on which `from` lies that is nearer; `None` inside a face.
    fn step(&self, around: &FacesAround, from: &Reach) -> Option<Reach> {
        let face = self.output.faces[from.face as usize];
        let on: [bool; 3] = from.weights.map(|w| w > 0.0);
        let pivot = on.iter().position(|&on| on)?;
        let n_on = on.iter().filter(|&&on| on).count();
        if n_on == 3 {
            return None;
        }
        let touches = |f: u32| {
            let other = self.output.faces[f as usize];
            n_on == 1 || (0..3).all(|i| !on[i] || other.contains(&face[i]))
        };
        let beyond = around.faces(face[pivot]).iter().copied().filter(|&f| f != from.face && touches(f));
        let mut best: Option<Reach> = None;
        for f in beyond {
            let limit = best.as_ref().map_or(from.distance * (1.0 - 1e-6), |b| b.distance);
            best = self.reach(f, limit).or(best);
        }
        best
    }
}

/// One step toward the solution of `(J'WJ + S) x = J'W h`: J holds barycentric weights times normals, W areas,
/// h heights of the points over their faces, S the weight of staying; preconditioned with lumped blocks of J'WJ.
fn solve(output: &Output, normals: &[Vec3], matches: &[Match]) -> Vec<DVec3> {
    let n = output.positions.len();
    let row = |m: &Match| (output.faces[m.face as usize], normals[m.face as usize].as_dvec3(), f64::from(m.area));
    let mut blocks = vec![[0.0f64; 6]; n];
    let mut residual = vec![DVec3::ZERO; n];
    for m in matches {
        let (face, normal, area) = row(m);
        let height = normal.dot(m.gap.as_dvec3());
        for (v, weight) in face.into_iter().zip(m.weights) {
            let w = area * f64::from(weight);
            let scaled = normal * w;
            let block = &mut blocks[v as usize];
            block[0] += scaled.x * normal.x;
            block[1] += scaled.x * normal.y;
            block[2] += scaled.x * normal.z;
            block[3] += scaled.y * normal.y;
            block[4] += scaled.y * normal.z;
            block[5] += scaled.z * normal.z;
            residual[v as usize] += scaled * height;
        }
    }
    let stay: Vec<f64> = blocks.iter().map(|b| STAY * (b[0] + b[3] + b[5]) + 1e-30).collect();
    let inverse: Vec<[f64; 6]> = blocks.iter().zip(&stay).map(|(b, s)| inverse(b, *s)).collect();
    let direction: Vec<DVec3> = residual.iter().zip(&inverse).map(|(r, m)| times(m, *r)).collect();
    let slope: f64 = residual.iter().zip(&direction).map(|(r, d)| r.dot(*d)).sum();
    let mut curvature: f64 = direction.iter().zip(&stay).map(|(d, s)| d.length_squared() * s).sum();
    for m in matches {
        let (face, normal, area) = row(m);
        let rise: f64 =
            face.iter().zip(m.weights).map(|(&v, w)| f64::from(w) * normal.dot(direction[v as usize])).sum();
        curvature += area * rise * rise;
    }
    let length = if curvature > 0.0 { slope / curvature } else { 0.0 };
    direction.into_iter().map(|d| d * length).collect()
}

/// Inverse of the symmetric block plus `stay` times the identity.
fn inverse(block: &[f64; 6], stay: f64) -> [f64; 6] {
    let [xx, xy, xz, yy, yz, zz] = *block;
    let (xx, yy, zz) = (xx + stay, yy + stay, zz + stay);
    let (c0, c1, c2) = (yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy);
    let d = 1.0 / (xx * c0 + xy * c1 + xz * c2);
    if !d.is_finite() {
        return [0.0; 6];
    }
    [c0, c1, c2, xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy].map(|c| c * d)
}

fn times(a: &[f64; 6], x: DVec3) -> DVec3 {
    DVec3::new(
        a[0] * x.x + a[1] * x.y + a[2] * x.z,
        a[1] * x.x + a[3] * x.y + a[4] * x.z,
        a[2] * x.x + a[4] * x.y + a[5] * x.z,
    )
}

/// Moves each vertex where no face around it turns.
fn take_steps(output: &mut Output, around: &FacesAround, steps: &[DVec3]) {
    for (v, step) in steps.iter().enumerate() {
        let target = (output.positions[v].as_dvec3() + *step).as_vec3();
        if !turns_a_face(output, around, v as u32, target) {
            output.positions[v] = target;
        }
    }
}

fn turns_a_face(output: &Output, around: &FacesAround, v: u32, target: Vec3) -> bool {
    around.faces(v).iter().any(|&f| {
        let face = output.faces[f as usize];
        let before = face.map(|w| output.positions[w as usize]);
        let after = face.map(|w| if w == v { target } else { output.positions[w as usize] });
        let (n, m) = (area_normal(before), area_normal(after));
        n.dot(m) < LEAST_COSINE * (n.length_squared() * m.length_squared()).sqrt()
    })
}

/// Puts vertices back whose own points lie farther away than before.
fn undo_what_does_not_pay(output: &mut Output, matches: &[Match], before: &[Vec3]) {
    let mut gain = vec![0.0f64; output.positions.len()];
    for m in matches {
        let face = output.faces[m.face as usize];
        let corners = face.map(|v| output.positions[v as usize]);
        let weights = nearest_weights(m.point, corners);
        let there = corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2];
        let closer = m.gap.length_squared() - there.distance_squared(m.point);
        for (v, weight) in face.into_iter().zip(m.weights) {
            gain[v as usize] += f64::from(m.area * weight * closer);
        }
    }
    for (v, gain) in gain.into_iter().enumerate() {
        if gain < 0.0 {
            output.positions[v] = before[v];
        }
    }
}

/// The faces around each vertex as compressed rows.
pub(super) struct FacesAround {
    starts: Vec<u32>,
    rows: Vec<u32>,
}

impl FacesAround {
    /// Sorts `faces` under their `n_vertices` corners.
    pub fn new(n_vertices: usize, faces: &[[u32; 3]]) -> Self {
        let mut starts = vec![0u32; n_vertices + 2];
        faces.as_flattened().iter().for_each(|&v| starts[v as usize + 2] += 1);
        (2..starts.len()).for_each(|v| starts[v] += starts[v - 1]);
        let mut rows = vec![0; 3 * faces.len()];
        for (f, face) in faces.iter().enumerate() {
            for &v in face {
                rows[starts[v as usize + 1] as usize] = f as u32;
                starts[v as usize + 1] += 1;
            }
        }
        Self { starts, rows }
    }

    /// The faces that use `vertex`.
    pub fn faces(&self, vertex: u32) -> &[u32] {
        &self.rows[self.starts[vertex as usize] as usize..self.starts[vertex as usize + 1] as usize]
    }
}
