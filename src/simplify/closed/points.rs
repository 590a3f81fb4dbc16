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
const BATCH: usize = 16 * CHUNK;
/// The face of a point that belongs to none.
const NONE: u32 = u32::MAX;

/// A point of the original over the output face that it belongs to.
#[derive(Clone, Copy)]
pub(super) struct Match {
    /// The input face whose centroid the point is.
    pub point: u32,
    /// Where it lies.
    pub at: Vec3,
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
        let Self { surface, vertex_of, ref mut faces } = *self;
        let (n_faces, n_points) = (surface.faces.len() as u64, faces.len() as u64);
        let mut found = Vec::new();
        for (batch, faces) in faces.chunks_mut(BATCH).enumerate() {
            let place = |(i, face): (usize, &mut u32)| {
                let point = ((batch * BATCH + i) as u64 * n_faces / n_points) as u32;
                let found = place_point(surface, facets, vertex_of, point, *face);
                *face = found.map_or(NONE, |m| m.place.face);
                found
            };
            faces.par_iter_mut().with_min_len(CHUNK).enumerate().map(place).collect_into_vec(&mut found);
            hand_on(&found);
        }
    }
}

/// Where the centroid of an input face belongs, looked for from output face `start` on, if that is known.
fn place_point(surface: &Surface, facets: &Facets, vertex_of: &[u32], point: u32, start: u32) -> Option<Match> {
    let face = surface.faces[point as usize];
    let corners = face.map(|v| surface.positions[v as usize]);
    let normal = area_normal(corners);
    let centroid = (corners[0] + corners[1] + corners[2]) * (1.0 / 3.0);
    let vertices = face.map(|v| vertex_of[v as usize]);
    let start = if start == NONE { facets.amid(vertices)? } else { start };
    let place = facets.place(centroid, normal, start, vertices[0])?;
    Some(Match { point, at: centroid, area: 0.5 * normal.length(), place })
}
