//! The output's faces as points of the original see them: which one a point belongs to, where in it, how far above it.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use crate::geometry::triangle::nearest_weights;
use crate::mesh::pulse::Pulse;
use glam::Vec3;

use crate::simplify::closed::output::Output;

/// Cosine between the normals of point and face above which a walk is believed not to have strayed over a crease.
/// Nineteen training meshes at ratios 0.01 to 0.05: the mean distance is 0.3 % farther at 0.6; at 0.95 it is 0.1 %
/// nearer, and more points are looked for around their vertex.
const AGREES: f32 = 0.8;
/// Edges that a walk may cross. At 6 and at 24 no figure moves by more than 0.3 % (sixteen training meshes, four
/// ratios).
const MOST_STEPS: usize = 12;
/// No face.
const NONE: u32 = u32::MAX;
/// A face that nobody has looked for yet.
const UNKNOWN: u32 = u32::MAX - 1;

/// A face as functions of the point, one cache line.
#[repr(align(64))]
pub struct Facet {
    /// Gradients of the barycentric weights of the first two corners.
    gradients: [Vec3; 2],
    /// Unit normal; zero where there is none, as the gradients are.
    pub normal: Vec3,
    /// Position of the third corner, where all of these are 0.
    origin: Vec3,
    /// The faces beyond the edges opposite to the corners, as far as they are known; `NONE` beyond a boundary.
    beyond: [AtomicU32; 3],
}

/// A point as it lies over a face.
#[derive(Clone, Copy, Default)]
pub struct Projection {
    /// The face.
    pub face: u32,
    /// Barycentric weights of about the nearest point in it, none negative, their sum 1.
    pub weights: [f32; 3],
    /// Height over the plane of the face.
    pub height: f32,
}

impl Facet {
    /// The face with these corners.
    pub fn new([a, b, origin]: [Vec3; 3]) -> Self {
        let (u, v) = (a - origin, b - origin);
        let area_normal = u.cross(v);
        let squared = area_normal.length_squared();
        let inverse = if squared > f32::MIN_POSITIVE { 1.0 / squared } else { 0.0 };
        let gradients = [v.cross(area_normal) * inverse, area_normal.cross(u) * inverse];
        Self { gradients, normal: area_normal * inverse.sqrt(), origin, beyond: [const { AtomicU32::new(UNKNOWN) }; 3] }
    }

    /// Height of a point over the plane of the face.
    pub fn height(&self, point: Vec3) -> f32 {
        self.normal.dot(point - self.origin)
    }

    /// The barycentric weights of the foot of a point, negative where it lies outside.
    pub fn weights(&self, point: Vec3) -> [f32; 3] {
        let offset = point - self.origin;
        let (u, v) = (self.gradients[0].dot(offset), self.gradients[1].dot(offset));
        [u, v, 1.0 - u - v]
    }
}

/// The faces of the output and their neighbourhoods.
pub struct Facets<'a> {
    facets: Vec<Facet>,
    /// What they are facets of.
    pub output: &'a Output,
}

impl<'a> Facets<'a> {
    /// Of all faces of an output.
    pub fn new(pulse: Pulse, output: &'a Output) -> Self {
        let facet = |face: &[u32; 3]| Facet::new(face.map(|v| output.positions[v as usize]));
        Self { facets: pulse.map(output.faces(), facet), output }
    }

    /// Unit normal of a face; zero where there is none.
    pub fn normal(&self, face: u32) -> Vec3 {
        self.facets[face as usize].normal
    }

    /// A face at the edge between the regions of a point's three vertices; none where they are all the same, or far
    /// apart.
    pub fn between(&self, [a, b, c]: [u32; 3]) -> Option<u32> {
        let [u, v] = if a != b { [a, b] } else { [b, c] };
        if u == v { None } else { self.output.around().along(u, v).or_else(|| self.output.around().along(v, u)) }
    }

    /// A face at a vertex; the first of all where it has none.
    pub fn at(&self, vertex: u32) -> u32 {
        self.output.around().corners(vertex).first().map_or(0, |corner| corner.face)
    }

    /// Whether there is no face.
    pub fn is_empty(&self) -> bool {
        self.facets.is_empty()
    }

    /// Walks from the `faces`, one per point, over edges toward the points, each until it lies over a face or beyond the
    /// edge just crossed.
    ///
    /// All points step at once, round by round: which of them go on is sorted out without a branch, so that no point
    /// waits for another's memory.
    pub fn walk(&self, points: &[Vec3], faces: &mut [u32]) {
        let mut from = vec![NONE; points.len()];
        let mut toward = vec![0u8; points.len()];
        let mut walking: Vec<usize> = (0..points.len()).collect();
        for _ in 0..MOST_STEPS {
            let mut n_outside = 0;
            for k in 0..walking.len() {
                let i = walking[k];
                let [u, v, w] = self.facets[faces[i] as usize].weights(points[i]);
                let least = u.min(v);
                toward[i] = if w < least { 2 } else { u8::from(v < u) };
                walking[n_outside] = i;
                n_outside += usize::from(least.min(w) < 0.0);
            }
            walking.truncate(n_outside);
            walking.retain(|&i| {
                let beyond = self.beyond(faces[i], usize::from(toward[i]));
                let goes = beyond != from[i] && beyond != NONE;
                if goes {
                    (from[i], faces[i]) = (faces[i], beyond);
                }
                goes
            });
        }
    }

    /// A point, at which the original has this normal of any length, as it lies over the face that a walk led to;
    /// or else over the nearest face around `vertex` that looks the same way.
    pub fn project(&self, point: Vec3, normal: Vec3, face: u32, vertex: u32) -> Option<Projection> {
        let facet = &self.facets[face as usize];
        let alike = facet.normal.dot(normal);
        let agrees = alike > 0.0 && alike * alike >= AGREES * AGREES * normal.length_squared();
        if !agrees {
            return self.nearest_around(point, normal, vertex);
        }
        let within = facet.weights(point).map(|w| w.max(0.0));
        let inverse = 1.0 / (within[0] + within[1] + within[2]);
        Some(Projection { face, weights: within.map(|w| w * inverse), height: facet.height(point) })
    }

    /// The face beyond the edge opposite to a corner (0, 1, 2), or `NONE`; looked for once and then remembered.
    fn beyond(&self, face: u32, corner: usize) -> u32 {
        let memory = &self.facets[face as usize].beyond[corner];
        let known = memory.load(Relaxed);
        if known != UNKNOWN {
            return known;
        }
        let corners = self.output.face(face);
        let found = self.output.around().along(corners[(corner + 2) % 3], corners[(corner + 1) % 3]).unwrap_or(NONE);
        memory.store(found, Relaxed);
        found
    }

    /// The nearest of the faces around `vertex` that look the same way.
    fn nearest_around(&self, point: Vec3, normal: Vec3, vertex: u32) -> Option<Projection> {
        let mut best: Option<(f32, Projection)> = None;
        for face in self.output.around().faces(vertex) {
            let facet = &self.facets[face as usize];
            if facet.normal.dot(normal) <= 0.0 {
                continue;
            }
            let corners = self.output.triangle(face);
            let weights = nearest_weights(point, corners);
            let foot = corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2];
            let distance = point.distance_squared(foot);
            if best.is_none_or(|(least, _)| distance < least) {
                best = Some((distance, Projection { face, weights, height: facet.height(point) }));
            }
        }
        best.map(|(_, projection)| projection)
    }
}
