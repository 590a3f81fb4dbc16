//! Points of the original, the centroids of its faces, and where in the output they belong.

use glam::Vec3;
use rayon::prelude::*;

use crate::geometry::triangle::area_normal;

use super::facets::{Facets, Place};
use super::surface::Surface;

/// Input faces looked at per output vertex, at most.
const POINTS_PER_VERTEX: usize = 14;
/// Points that one thread places in a row.
const CHUNK: usize = 1024;
/// Points that are placed before they are handed on: few enough to stay in the cache.
const BATCH: usize = 4 * CHUNK;
/// Vertices of whose faces the last one found is kept in mind.
const REMEMBERED: usize = 128;
/// The face of a point that belongs to none.
const NONE: u32 = u32::MAX;

/// A point of the original over the output face that it belongs to.
#[derive(Clone, Copy)]
pub(super) struct Match {
    /// The input face whose centroid the point is.
    pub point: u32,
    /// Area of the input face.
    pub area: f32,
    /// The output face, and where over it.
    pub place: Place,
}

/// Points spread evenly over the faces of the original.
pub(super) struct Points<'a> {
    surface: &'a Surface,
    /// For each input vertex the output vertex that its region became.
    vertex_of: &'a [u32],
    /// The face that each point belonged to the last time.
    faces: Vec<u32>,
}

impl<'a> Points<'a> {
    /// As many points as so many output vertices ask for; `vertex_of` names the output vertex of each input vertex.
    pub fn new(surface: &'a Surface, vertex_of: &'a [u32], n_output: usize) -> Self {
        let n_points = surface.faces.len().min(POINTS_PER_VERTEX * n_output);
        Self { surface, vertex_of, faces: vec![NONE; n_points] }
    }

    /// Finds the places of all points and hands them on in batches, in order.
    pub fn place(&mut self, facets: &Facets, mut hand_on: impl FnMut(&[Option<Match>])) {
        let n_points = self.faces.len();
        let mut faces = std::mem::take(&mut self.faces);
        let mut found = vec![None; n_points.min(BATCH)];
        for (batch, faces) in faces.chunks_mut(BATCH).enumerate() {
            let found = &mut found[..faces.len()];
            let chunks = faces.par_chunks_mut(CHUNK).zip(found.par_chunks_mut(CHUNK)).enumerate();
            chunks.for_each(|(chunk, (faces, found))| {
                let first = batch * BATCH + chunk * CHUNK;
                let point = |i: usize| ((first + i) as u64 * self.surface.faces.len() as u64 / n_points as u64) as u32;
                self.begin(facets, point, faces);
                self.place_run(facets, point, faces, found);
            });
            hand_on(found);
        }
        self.faces = faces;
    }

    /// The output vertices of the corners of an input face.
    fn vertices(&self, point: u32) -> [u32; 3] {
        self.surface.faces[point as usize].map(|v| self.vertex_of[v as usize])
    }

    /// Faces to begin at, where regions meet, for points that have none yet.
    fn begin(&self, facets: &Facets, point: impl Fn(usize) -> u32, faces: &mut [u32]) {
        for (i, face) in faces.iter_mut().enumerate().filter(|(_, face)| **face == NONE) {
            *face = facets.between(self.vertices(point(i))).unwrap_or(NONE);
        }
    }

    /// Finds the places of a run of points from the faces to begin at, or else from where the last point of the same
    /// region is.
    fn place_run(&self, facets: &Facets, point: impl Fn(usize) -> u32, faces: &mut [u32], found: &mut [Option<Match>]) {
        let mut last = [(NONE, NONE); REMEMBERED];
        for (i, (face, found)) in faces.iter_mut().zip(found).enumerate() {
            let point = point(i);
            let vertex = self.vertices(point)[0];
            let last = &mut last[vertex as usize % REMEMBERED];
            let near = if last.0 == vertex { Some(last.1) } else { facets.at(vertex) };
            let start = if *face == NONE { near } else { Some(*face) };
            *found = start.and_then(|start| self.place_point(facets, point, start, vertex));
            *face = found.map_or(NONE, |m| m.place.face);
            if *face != NONE {
                *last = (vertex, *face);
            }
        }
    }

    /// Where the centroid of an input face belongs, looked for from output face `start` on, or around `vertex`.
    fn place_point(&self, facets: &Facets, point: u32, start: u32, vertex: u32) -> Option<Match> {
        let corners = self.surface.faces[point as usize].map(|v| self.surface.positions[v as usize]);
        let normal = area_normal(corners);
        let place = facets.place(centroid(corners), normal, start, vertex)?;
        Some(Match { point, area: 0.5 * normal.length(), place })
    }

    /// Where a point lies.
    pub fn position(&self, point: u32) -> Vec3 {
        centroid(self.surface.faces[point as usize].map(|v| self.surface.positions[v as usize]))
    }
}

fn centroid(corners: [Vec3; 3]) -> Vec3 {
    (corners[0] + corners[1] + corners[2]) * (1.0 / 3.0)
}
