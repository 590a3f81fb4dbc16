//! The mesh being made: created by the collapse, updated by every later step.

use glam::Vec3;

use crate::geometry::triangle::unit_normal;
use crate::mesh::Attributes;
use crate::mesh::pulse::Pulse;
use crate::spatial::NearestOnTriangles;

use super::attributes::result_corners::{CornerMap, ResultCorners};
use super::diamond::Diamond;
use super::faces_around::FacesAround;
use super::original::Original;
use super::pins::Pins;
use super::prepare::surface::PreparedSurface;

pub struct Output {
    pub positions: Vec<Vec3>,
    faces: Vec<[u32; 3]>,
    /// Unit normals of the faces after the collapse, a limit for later turns; zero if unknown.
    intended_normals: Vec<Vec3>,
    around: FacesAround,
    pub pins: Pins,
    pub vertex_of: Vec<u32>,
    /// Largest distance of each vertex from the original, as the collapse has followed it; empty if it has not.
    distances: Vec<f32>,
    /// True if merges may have left the curves that held them.
    has_free_curves: bool,
    corners: Option<ResultCorners>,
}

impl Output {
    pub fn new(pulse: Pulse, positions: Vec<Vec3>, faces: Vec<[u32; 3]>, pins: Pins, vertex_of: Vec<u32>) -> Self {
        let intended_normals = pulse.map(&faces, |face| unit_normal(face.map(|v| positions[v as usize])));
        let around = FacesAround::new(pulse, positions.len(), &faces);
        Self {
            positions,
            faces,
            intended_normals,
            around,
            pins,
            vertex_of,
            distances: Vec::new(),
            has_free_curves: false,
            corners: None,
        }
    }

    pub fn with_free_curves(self, has_free_curves: bool) -> Self {
        Self { has_free_curves, ..self }
    }

    pub fn with_distances(self, distances: Vec<f32>) -> Self {
        Self { distances, ..self }
    }

    /// Returns whether a vertex may be farther than this from the original.
    pub fn may_be_beyond(&self, v: u32, distance: f32) -> bool {
        // Also where nothing is known.
        self.distances.get(v as usize).is_none_or(|known| known.is_nan() || *known > distance)
    }

    /// Moves a vertex to where its distance from the original is unknown.
    pub fn move_vertex(&mut self, v: u32, position: Vec3) {
        self.positions[v as usize] = position;
        if let Some(known) = self.distances.get_mut(v as usize) {
            *known = f32::INFINITY;
        }
    }

    /// Records the attributes of the corners; must precede the first flip.
    pub fn record_attributes(&mut self, original: &Original, attributes: &Attributes) {
        let mesh = (&self.faces[..], &self.around);
        let corners = ResultCorners::new(original, attributes, &self.vertex_of, mesh, self.has_free_curves);
        self.corners = Some(corners);
    }

    /// Computes the final attributes and the original point at each corner, if attributes were recorded.
    pub fn take_attributes(&mut self, original: &Original, attributes: &Attributes) -> Option<(Attributes, CornerMap)> {
        let corners = self.corners.take()?;
        Some(corners.attributes(original, attributes, &self.positions, &self.pins))
    }

    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    pub fn face(&self, f: u32) -> [u32; 3] {
        self.faces[f as usize]
    }

    pub fn triangle(&self, f: u32) -> [Vec3; 3] {
        self.face(f).map(|v| self.positions[v as usize])
    }

    pub fn coordinates(&self, f: u32) -> [[f32; 3]; 3] {
        self.triangle(f).map(|p| p.to_array())
    }

    pub fn tree(&self) -> NearestOnTriangles {
        let coordinates = (0..self.faces.len() as u32).map(|f| self.coordinates(f));
        NearestOnTriangles::new(&coordinates.collect::<Vec<_>>())
    }

    pub fn intended_normal(&self, f: u32) -> Vec3 {
        self.intended_normals[f as usize]
    }

    pub fn faces_around(&self) -> &FacesAround {
        &self.around
    }

    pub fn is_flip_forbidden(&self, Diamond { faces, corners: [a, b, _, _] }: &Diamond) -> bool {
        // The edge is kept or a seam.
        let is_seam = |corners: &ResultCorners| corners.is_seam(&self.faces, *faces, [*a, *b]);
        self.pins.locks_edge(*a, *b) || self.corners.as_ref().is_some_and(is_seam)
    }

    pub fn flip(&mut self, diamond: &Diamond) {
        let before = diamond.faces.map(|f| self.face(f));
        self.swap_diagonal(diamond);
        for (f, before) in diamond.faces.into_iter().zip(before) {
            self.around.replace_face(f, before, self.faces[f as usize]);
        }
    }

    pub fn flip_all(&mut self, pulse: Pulse, diamonds: &[Diamond]) {
        diamonds.iter().for_each(|diamond| self.swap_diagonal(diamond));
        if !diamonds.is_empty() {
            self.around = FacesAround::new(pulse, self.positions.len(), &self.faces);
        }
    }

    fn swap_diagonal(&mut self, diamond: &Diamond) {
        let [f, g] = diamond.faces.map(|f| f as usize);
        // Wedges are updated first: they are found by the corners of the old faces.
        self.corners.iter_mut().for_each(|corners| corners.flip(&self.faces, diamond.faces, diamond.corners));
        [self.faces[f], self.faces[g]] = diamond.flipped_faces();
        // Both new faces cover the region of both old ones, so they share the mean intended direction.
        self.intended_normals[f] = (self.intended_normals[f] + self.intended_normals[g]).normalize_or_zero();
        self.intended_normals[g] = self.intended_normals[f];
    }

    /// Moves a vertex to the position of the surface vertex `origin` (option `subset`).
    pub fn move_to_surface_vertex(&mut self, v: u32, origin: u32, surface: &PreparedSurface) {
        self.positions[v as usize] = surface.positions[origin as usize];
        self.pins.set_origin(v, origin);
    }

    pub fn into_parts(self) -> (Vec<[u32; 3]>, Pins, Vec<u32>) {
        (self.faces, self.pins, self.vertex_of)
    }
}

#[cfg(test)]
impl Output {
    pub fn from_original(original: &[Vec3], positions: Vec<Vec3>, faces: Vec<[u32; 3]>) -> Self {
        let nearest = |p: &Vec3| {
            let distance = |v: &u32| positions[*v as usize].distance_squared(*p);
            (0..positions.len() as u32).min_by(|v, w| distance(v).total_cmp(&distance(w))).unwrap_or(0)
        };
        let vertex_of = original.iter().map(nearest).collect();
        Self::new(Pulse::NONE, positions, faces, Pins::default(), vertex_of)
    }
}
