//! Sample points of the original and their assignment to output faces.

use glam::Vec3;

use crate::geometry::triangle::area_normal;
use crate::mesh::pulse::Pulse;
use crate::parallel;

use crate::simplify::closed::prepare::surface::PreparedSurface;
use crate::simplify::closed::stage_settings::StageSettings;

use super::facets::{Facets, Projection};

// Points assigned by one thread in a row: they fill the first-level cache. The number affects only where walks begin.
const CHUNK: usize = 512;
// Points assigned before they are passed on: 1 MiB of positions, enough work for 64 threads.
const BATCH: usize = 64 * CHUNK;
const REMEMBERED: usize = 128;
const NONE: u32 = u32::MAX;

#[derive(Clone, Copy)]
pub struct Match {
    pub point: u32,
    pub area: f32,
    pub projection: Projection,
}

/// Number of sample points per face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Density {
    One,
    /// Three points with weights 2/3, 1/6 and 1/6, exact for quadratic functions (Strang and Fix 1973).
    Three,
}

impl Density {
    pub fn per_face(self) -> u32 {
        match self {
            Self::One => 1,
            Self::Three => 3,
        }
    }

    pub fn face(self, point: u32) -> usize {
        (point / self.per_face()) as usize
    }

    pub fn weights(self, point: u32) -> [f64; 3] {
        match self {
            Self::One => [1.0 / 3.0; 3],
            Self::Three => std::array::from_fn(|corner| if corner as u32 == point % 3 { 2.0 / 3.0 } else { 1.0 / 6.0 }),
        }
    }
}

pub struct SamplePoints<'a> {
    surface: &'a PreparedSurface<'a>,
    density: Density,
    most: usize,
    n_steps: usize,
    settings: StageSettings,
    faces: Vec<u32>,
}

impl<'a> SamplePoints<'a> {
    /// Chooses the points for this many output vertices, at most one per face.
    pub fn new(surface: &'a PreparedSurface<'a>, n_output: usize, settings: StageSettings) -> Self {
        let n_faces = surface.faces.len();
        // Near the size of the input there is little to gain, so one point a face and one step suffice.
        let most = settings.points_per_vertex * n_output;
        let n_steps = if n_faces < settings.few_faces * n_output { 1 } else { settings.steps };
        Self { surface, density: Density::One, most, n_steps, settings, faces: vec![NONE; most.min(n_faces)] }
    }

    /// Places three points on each face, if that many are allowed, starting at their centroid's output face.
    pub fn use_three_per_face(&mut self) {
        // If one point a face already exceeds the limit, three would only be thinned out.
        let one = self.faces.len();
        if self.density == Density::Three || one < self.surface.faces.len() {
            return;
        }
        self.density = Density::Three;
        let centroids = std::mem::take(&mut self.faces);
        let n_points = self.most.min(self.n_all());
        let stride = self.stride(n_points);
        // A point starts where its face's centroid ended.
        let face = |i: usize| centroids[self.density.face(nth(i as u64, stride))];
        self.faces = self.surface.pulse.counting_if(false).map_numbers(n_points, face);
    }

    /// Assigns all points to output faces and passes the matches to `receive` in batches.
    pub fn assign(&mut self, facets: &Facets, mut receive: impl FnMut(&[Option<Match>])) {
        if facets.is_empty() {
            return;
        }
        // Batches keep points and positions in the cache between assignment and summing.
        let n_points = self.faces.len();
        let stride = self.stride(n_points);
        let mut faces = std::mem::take(&mut self.faces);
        let mut found = vec![None; n_points.min(BATCH)];
        for (batch, faces) in faces.chunks_mut(BATCH).enumerate() {
            let found = &mut found[..faces.len()];
            let chunks = faces.chunks_mut(CHUNK).zip(found.chunks_mut(CHUNK)).enumerate();
            parallel::each(chunks, |(chunk, (faces, found))| {
                let first = (batch * BATCH + chunk * CHUNK) as u64;
                let points = (first..first + faces.len() as u64).map(|i| nth(i, stride));
                self.assign_run(facets, points.collect(), faces, found);
            });
            receive(found);
            self.surface.pulse.beat(found.len());
        }
        self.faces = faces;
    }

    fn assign_run(&self, facets: &Facets, points: Vec<u32>, faces: &mut [u32], found: &mut [Option<Match>]) {
        // All points of a run walk together before they are projected.
        self.choose_start_faces(facets, &points, faces);
        let corners = |point: u32| self.corners(point).map(|v| self.surface.positions[v as usize]);
        let share = 0.5 / self.density.per_face() as f32;
        let places: Vec<Vec3> = points.iter().map(|&point| self.position(point)).collect();
        facets.walk(&places, faces);
        for (i, &point) in points.iter().enumerate() {
            let normal = area_normal(corners(point));
            let vertex = facets.output.vertex_of[self.nearest_corner(point) as usize];
            let projection = facets.project(places[i], normal, faces[i], vertex);
            found[i] = projection.map(|projection| Match { point, area: share * normal.length(), projection });
            faces[i] = projection.map_or(NONE, |projection| projection.face);
        }
    }

    /// Chooses start faces for unassigned points: at the edge between two regions, else the region's last start face.
    fn choose_start_faces(&self, facets: &Facets, points: &[u32], faces: &mut [u32]) {
        let mut last = [(NONE, NONE); REMEMBERED];
        for (&point, face) in points.iter().zip(faces).filter(|(_, face)| **face == NONE) {
            let vertices = self.corners(point).map(|v| facets.output.vertex_of[v as usize]);
            let last = &mut last[vertices[0] as usize % REMEMBERED];
            *face = match facets.face_between(vertices) {
                Some(between) => between,
                None if last.0 == vertices[0] => last.1,
                None => facets.face_at(vertices[0]),
            };
            *last = (vertices[0], *face);
        }
    }

    pub fn pulse(&self) -> Pulse<'a> {
        self.surface.pulse
    }

    pub fn len(&self) -> usize {
        self.faces.len()
    }

    fn n_all(&self) -> usize {
        self.surface.faces.len() * self.density.per_face() as usize
    }

    fn stride(&self, n_points: usize) -> u64 {
        // Fixed-point arithmetic spreads the points evenly without rounding errors.
        ((self.n_all() as u64) << 32) / n_points.max(1) as u64
    }

    pub fn density(&self) -> Density {
        self.density
    }

    pub fn n_steps(&self) -> usize {
        self.n_steps
    }

    pub fn settings(&self) -> StageSettings {
        self.settings
    }

    pub fn thinning(&self) -> f32 {
        self.n_all() as f32 / self.faces.len().max(1) as f32
    }

    pub fn have_boundary(&self) -> bool {
        self.surface.rings.n_ghosts() > 0
    }

    pub fn position(&self, point: u32) -> Vec3 {
        let [a, b, c] = self.corners(point).map(|v| self.surface.positions[v as usize]);
        match self.density {
            Density::One => (a + b + c) * (1.0 / 3.0),
            Density::Three => (a + b + c + [a, b, c][point as usize % 3] * 3.0) * (1.0 / 6.0),
        }
    }

    fn corners(&self, point: u32) -> [u32; 3] {
        self.surface.faces[self.density.face(point)]
    }

    fn nearest_corner(&self, point: u32) -> u32 {
        match self.density {
            Density::One => self.corners(point)[0],
            Density::Three => self.corners(point)[point as usize % 3],
        }
    }
}

fn nth(i: u64, stride: u64) -> u32 {
    ((i * stride) >> 32) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::triangle::nearest_point;
    use crate::mesh::shapes;
    use crate::simplify::closed::output::Output;

    #[test]
    fn points_belong_to_the_faces_that_a_search_of_all_finds() {
        let mesh = shapes::wavy_sphere(4, 3.0);
        let surface = PreparedSurface::new(&mesh, Pulse::NONE);
        let coarse = shapes::icosphere(2);
        // Subdivision appends vertices, so a finer sphere begins with those of the coarser one.
        let positions = surface.positions[..coarse.positions().len()].to_vec();
        let output = Output::from_original(&surface.positions, positions.clone(), coarse.faces().to_vec());
        let facets = Facets::new(Pulse::NONE, &output);
        let (mut points, points_of_all) = (
            SamplePoints::new(&surface, surface.faces.len(), StageSettings::default()),
            SamplePoints::new(&surface, surface.faces.len(), StageSettings::default()),
        );
        let (mut n_found, mut n_like_naive) = (0, 0);
        points.assign(&facets, |matches| {
            for m in matches.iter().flatten() {
                let corners = |f: &[u32; 3]| f.map(|v| positions[v as usize]);
                let at = points_of_all.position(m.point);
                let [a, b, c] = corners(&coarse.faces()[m.projection.face as usize]);
                let [u, v, w] = m.projection.weights;
                let naive = coarse.faces().iter().map(|f| nearest_point(at, corners(f)).distance(at));
                let naive = naive.fold(f32::INFINITY, f32::min);
                n_found += 1;
                n_like_naive += usize::from((a * u + b * v + c * w).distance(at) < 1.01 * naive + 1e-6);
                assert!(m.projection.weights.iter().all(|w| *w >= 0.0) && (u + v + w - 1.0).abs() < 1e-5);
                assert!(m.projection.height.abs() <= naive + 1e-5);
            }
        });
        assert_eq!(n_found, surface.faces.len());
        assert!(n_like_naive as f64 > 0.97 * f64::from(n_found as u32), "{n_like_naive} of {n_found}");
    }
}
