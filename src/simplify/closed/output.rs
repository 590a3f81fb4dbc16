//! The output: made once by the collapse, kept in step by every later step, handed out at the end.

use glam::Vec3;

use crate::geometry::triangle::unit_normal;
use crate::mesh::Attributes;
use crate::mesh::pulse::Pulse;
use crate::spatial::NearestOnTriangles;

use super::attributes::corners::{CornerMap, Corners};
use super::diamond::Diamond;
use super::faces_around::FacesAround;
use super::original::Original;
use super::pins::Pins;
use super::prepare::surface::Surface;

/// The lighter mesh while it is made.
pub struct Output {
    /// Normalised positions, n_vertices x 3.
    pub positions: Vec<Vec3>,
    /// Faces, n_faces x 3.
    faces: Vec<[u32; 3]>,
    /// Which way the faces are meant to look, unit normals, n_faces x 3; zero where nothing says.
    meant: Vec<Vec3>,
    /// The faces around each vertex.
    around: FacesAround,
    /// What may not move.
    pub pins: Pins,
    /// For each vertex of the surface the output vertex that its region became.
    pub vertex_of: Vec<u32>,
    /// What the corners carry, where they carry anything.
    corners: Option<Corners>,
}

impl Output {
    /// What a collapse left: positions (n_vertices x 3), faces (n_faces x 3), what may not move, and for each vertex of the surface
    /// the output vertex that its region became. Faces are meant to look as they do now.
    pub fn new(pulse: Pulse, positions: Vec<Vec3>, faces: Vec<[u32; 3]>, pins: Pins, vertex_of: Vec<u32>) -> Self {
        let meant = pulse.map(&faces, |face| unit_normal(face.map(|v| positions[v as usize])));
        let around = FacesAround::new(pulse, positions.len(), &faces);
        Self { positions, faces, meant, around, pins, vertex_of, corners: None }
    }

    /// Takes note of what the corners carry; before the first flip.
    pub fn carry(&mut self, original: &Original, attributes: &Attributes) {
        self.corners = Some(Corners::new(original, attributes, &self.vertex_of, &self.faces, &self.around));
    }

    /// What the corners carry in the end, and where on the original they stand; nothing where that was not asked for.
    pub fn carried(&mut self, original: &Original, attributes: &Attributes) -> Option<(Attributes, CornerMap)> {
        let corners = self.corners.take()?;
        Some(corners.attributes(original, attributes, &self.positions, &self.pins))
    }

    /// Faces, n_faces x 3.
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// The corners of a face, as indices.
    pub fn face(&self, f: u32) -> [u32; 3] {
        self.faces[f as usize]
    }

    /// The corners of a face, as points.
    pub fn triangle(&self, f: u32) -> [Vec3; 3] {
        self.face(f).map(|v| self.positions[v as usize])
    }

    /// The same, as searches and tests of crossing take it.
    pub fn coordinates(&self, f: u32) -> [[f32; 3]; 3] {
        self.triangle(f).map(|p| p.to_array())
    }

    /// The faces, to be searched.
    pub fn tree(&self) -> NearestOnTriangles {
        let coordinates = (0..self.faces.len() as u32).map(|f| self.coordinates(f));
        NearestOnTriangles::new(&coordinates.collect::<Vec<_>>())
    }

    /// Which way a face is meant to look.
    pub fn meant(&self, f: u32) -> Vec3 {
        self.meant[f as usize]
    }

    /// The faces around each vertex.
    pub fn around(&self) -> &FacesAround {
        &self.around
    }

    /// Whether the edge of a diamond may not be flipped: it is a seam or one of a kept face, or the other diagonal would join two
    /// vertices of a half's plane.
    pub fn is_held(&self, Diamond { faces, corners: [a, b, c, d] }: &Diamond) -> bool {
        let is_seam = |corners: &Corners| corners.is_seam(&self.faces, *faces, [*a, *b]);
        self.pins.are_on_cut(*c, *d) || self.pins.hold_edge(*a, *b) || self.corners.as_ref().is_some_and(is_seam)
    }

    /// Gives a diamond its other diagonal.
    pub fn flip(&mut self, diamond: &Diamond) {
        let before = diamond.faces.map(|f| self.face(f));
        self.swap_diagonal(diamond);
        for (f, before) in diamond.faces.into_iter().zip(before) {
            self.around.replace(f, before, self.faces[f as usize]);
        }
    }

    /// Gives diamonds that share no face their other diagonals.
    pub fn flip_all(&mut self, pulse: Pulse, diamonds: &[Diamond]) {
        diamonds.iter().for_each(|diamond| self.swap_diagonal(diamond));
        if !diamonds.is_empty() {
            self.around = FacesAround::new(pulse, self.positions.len(), &self.faces);
        }
    }

    fn swap_diagonal(&mut self, diamond: &Diamond) {
        let [f, g] = diamond.faces.map(|f| f as usize);
        self.corners.iter_mut().for_each(|corners| corners.flip(&self.faces, diamond.faces, diamond.corners));
        [self.faces[f], self.faces[g]] = diamond.flipped();
        self.meant[f] = (self.meant[f] + self.meant[g]).normalize_or_zero();
        self.meant[g] = self.meant[f];
    }

    /// Puts a vertex where a vertex of the surface lies.
    pub fn stand_on(&mut self, v: u32, origin: u32, surface: &Surface) {
        self.positions[v as usize] = surface.positions[origin as usize];
        self.pins.set_origin(v, origin);
    }

    /// Faces, what may not move, and for each vertex of the surface the output vertex: what is handed out beside positions.
    pub fn into_parts(self) -> (Vec<[u32; 3]>, Pins, Vec<u32>) {
        (self.faces, self.pins, self.vertex_of)
    }
}

#[cfg(test)]
impl Output {
    /// Faces over vertices of an original, whose vertices belong to the closest of them; nothing is pinned.
    pub fn over(original: &[Vec3], positions: Vec<Vec3>, faces: Vec<[u32; 3]>) -> Self {
        let nearest = |p: &Vec3| {
            let distance = |v: &u32| positions[*v as usize].distance_squared(*p);
            (0..positions.len() as u32).min_by(|v, w| distance(v).total_cmp(&distance(w))).unwrap_or(0)
        };
        let vertex_of = original.iter().map(nearest).collect();
        Self::new(Pulse::NONE, positions, faces, Pins::default(), vertex_of)
    }
}
