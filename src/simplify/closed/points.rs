//! Points of the original, the centroids of its faces, and where in the output they belong.

use glam::Vec3;
use rayon::prelude::*;

use crate::geometry::triangle::area_normal;

use super::facets::{Facets, Place};
use super::surface::Surface;

/// Input faces looked at per output vertex, at most.
const POINTS_PER_VERTEX: usize = 14;
/// Points that one thread places in a row.
const CHUNK: usize = 512;
/// Points that are placed before they are handed on: few enough to stay in the cache.
const BATCH: usize = 8 * CHUNK;
/// Vertices of whose faces one is kept in mind.
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
        if facets.is_empty() {
            return;
        }
        let n_points = self.faces.len();
        let stride = ((self.surface.faces.len() as u64) << 32) / n_points.max(1) as u64;
        let mut faces = std::mem::take(&mut self.faces);
        let mut found = vec![None; n_points.min(BATCH)];
        for (batch, faces) in faces.chunks_mut(BATCH).enumerate() {
            let found = &mut found[..faces.len()];
            let chunks = faces.par_chunks_mut(CHUNK).zip(found.par_chunks_mut(CHUNK)).enumerate();
            chunks.for_each(|(chunk, (faces, found))| {
                let first = (batch * BATCH + chunk * CHUNK) as u64;
                let points = (first..first + faces.len() as u64).map(|i| (i * stride >> 32) as u32);
                self.place_run(facets, points.collect(), faces, found);
            });
            hand_on(found);
        }
        self.faces = faces;
    }

    /// Finds the places of a run of points from the faces where they were the last time, or else from those where they
    /// may be.
    fn place_run(&self, facets: &Facets, points: Vec<u32>, faces: &mut [u32], found: &mut [Option<Match>]) {
        self.begin(facets, &points, faces);
        let corners = |point: u32| self.surface.faces[point as usize].map(|v| self.surface.positions[v as usize]);
        let places: Vec<Vec3> = points.iter().map(|&point| centroid(corners(point))).collect();
        facets.walk(&places, faces);
        for (i, &point) in points.iter().enumerate() {
            let normal = area_normal(corners(point));
            let vertex = self.vertex_of[self.surface.faces[point as usize][0] as usize];
            let place = facets.place(places[i], normal, faces[i], vertex);
            found[i] = place.map(|place| Match { point, area: 0.5 * normal.length(), place });
            faces[i] = place.map_or(NONE, |place| place.face);
        }
    }

    /// Faces to begin at for points that have none: where regions meet, and amid a region the last one of these.
    fn begin(&self, facets: &Facets, points: &[u32], faces: &mut [u32]) {
        let mut last = [(NONE, NONE); REMEMBERED];
        for (&point, face) in points.iter().zip(faces).filter(|(_, face)| **face == NONE) {
            let vertices = self.surface.faces[point as usize].map(|v| self.vertex_of[v as usize]);
            let last = &mut last[vertices[0] as usize % REMEMBERED];
            *face = match facets.between(vertices) {
                Some(between) => between,
                None if last.0 == vertices[0] => last.1,
                None => facets.at(vertices[0]),
            };
            *last = (vertices[0], *face);
        }
    }

    /// Where a point lies.
    pub fn position(&self, point: u32) -> Vec3 {
        centroid(self.surface.faces[point as usize].map(|v| self.surface.positions[v as usize]))
    }
}

fn centroid(corners: [Vec3; 3]) -> Vec3 {
    (corners[0] + corners[1] + corners[2]) * (1.0 / 3.0)
}
