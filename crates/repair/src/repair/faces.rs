//! The faces of a mesh during repair.

use glam::{DVec3, Vec3};

use crate::geometry::triangle::area_normal_f64;
use crate::mesh::{Attributes, TriMesh, compact};

use super::{RepairCounts, Repaired};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FaceOrigin {
    /// Input face as read.
    AsRead,
    /// Input face, reversed.
    Turned,
    /// Face over a hole.
    New,
}

#[derive(Clone, Debug)]
pub(super) struct RepairFaces<'a> {
    pub positions: &'a [[f32; 3]],
    pub corners: Vec<[u32; 3]>,
    wedges: Vec<[u32; 3]>,
    groups: Vec<u32>,
    pub origins: Vec<FaceOrigin>,
    /// Index in the input of each face, n_faces; `u32::MAX` over a hole.
    pub sources: Vec<u32>,
}

impl<'a> RepairFaces<'a> {
    pub fn new(mesh: &'a TriMesh, attributes: &Attributes) -> Self {
        Self {
            positions: mesh.positions(),
            corners: mesh.faces().to_vec(),
            wedges: attributes.wedges.clone(),
            groups: attributes.groups.clone(),
            origins: vec![FaceOrigin::AsRead; mesh.faces().len()],
            sources: (0..mesh.faces().len() as u32).collect(),
        }
    }

    pub fn len(&self) -> usize {
        self.corners.len()
    }

    pub fn position(&self, vertex: u32) -> DVec3 {
        Vec3::from(self.positions[vertex as usize]).as_dvec3()
    }

    pub fn points(&self, face: u32) -> [DVec3; 3] {
        self.corners[face as usize].map(|vertex| self.position(vertex))
    }

    pub fn normal(&self, face: u32) -> DVec3 {
        area_normal_f64(self.points(face))
    }

    pub fn area(&self, face: u32) -> f64 {
        0.5 * self.normal(face).length()
    }

    pub fn wedge_at(&self, face: u32, vertex: u32) -> u32 {
        let place = self.corners[face as usize].iter().position(|&v| v == vertex).unwrap_or(0);
        self.wedges.get(face as usize).map_or(0, |wedges| wedges[place])
    }

    pub fn group(&self, face: u32) -> u32 {
        self.groups.get(face as usize).copied().unwrap_or(0)
    }

    pub fn turn(&mut self, face: u32) {
        let face = face as usize;
        self.corners[face].swap(1, 2);
        if let Some(wedges) = self.wedges.get_mut(face) {
            wedges.swap(1, 2);
        }
        self.origins[face] = match self.origins[face] {
            FaceOrigin::AsRead => FaceOrigin::Turned,
            FaceOrigin::Turned => FaceOrigin::AsRead,
            FaceOrigin::New => FaceOrigin::New,
        };
    }

    pub fn push(&mut self, corners: [u32; 3], wedges: [u32; 3], group: u32) {
        if !self.wedges.is_empty() {
            self.wedges.push(wedges);
        }
        if !self.groups.is_empty() {
            self.groups.push(group);
        }
        self.corners.push(corners);
        self.origins.push(FaceOrigin::New);
        self.sources.push(u32::MAX);
    }

    pub fn retain(&mut self, is_wanted: impl Fn(u32) -> bool) {
        fn retain_rows<T: Copy>(rows: &mut Vec<T>, is_wanted: &impl Fn(u32) -> bool) {
            let mut number = 0..;
            rows.retain(|_| number.next().is_some_and(is_wanted));
        }
        retain_rows(&mut self.corners, &is_wanted);
        retain_rows(&mut self.wedges, &is_wanted);
        retain_rows(&mut self.groups, &is_wanted);
        retain_rows(&mut self.origins, &is_wanted);
        retain_rows(&mut self.sources, &is_wanted);
    }

    pub fn numbers(&self) -> std::ops::Range<u32> {
        0..self.corners.len() as u32
    }

    /// Builds the mesh with the channels of `attributes`; adds face counts to `counts`.
    pub fn into_repaired(self, attributes: &Attributes, counts: RepairCounts) -> Repaired {
        let mut attributes = Attributes { wedges: Vec::new(), groups: Vec::new(), ..attributes.clone() };
        let n_read = self.origins.iter().filter(|made| **made != FaceOrigin::New).count();
        let n_turned = self.origins.iter().filter(|made| **made == FaceOrigin::Turned).count();
        let counts = RepairCounts { faces_added: self.len() - n_read, faces_turned: n_turned, ..counts };
        attributes.wedges = self.wedges.clone();
        // This precedes the compaction of positions, since it needs the reversed faces' new normals.
        let turned = self.numbers().filter(|&face| self.origins[face as usize] == FaceOrigin::Turned);
        attributes.turn_normals(turned.map(|face| (face, self.normal(face))));
        attributes.groups = self.groups;
        let (mesh, sources) = compact(self.positions, self.corners).unwrap_or_default();
        Repaired { mesh, attributes, sources, counts }
    }
}
