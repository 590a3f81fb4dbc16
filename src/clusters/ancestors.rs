//! Ancestors: faces of an earlier level, against which the results of several levels are proved.
//!
//! Bounds that are proved from level to level add up, and errors about double with each level. Against an earlier level
//! fewer of them add up. Each point of the input belongs to one ancestor and, at each level, to one face. A face lists
//! the ancestors of all points that belong to it, and perhaps some more.

use glam::{DVec3, Vec3};
use rustc_hash::FxHashMap;

use crate::mesh::DistinctKeys;

use super::overlay_surface::{OverlaySurface, centroid};
use super::vertices::{PoolFace, VertexPool};

/// Ancestors of some faces, one list per face.
#[derive(Clone, Default)]
pub struct AncestorLists {
    ends: Vec<u32>,
    numbers: Vec<u32>,
}

/// Faces of an earlier level, with their bounds.
#[derive(Default)]
pub struct Ancestors {
    faces: Vec<PoolFace>,
    /// Number of live faces that list each.
    n_users: Vec<u32>,
    /// Levels since then.
    pub age: usize,
    /// True if the next level has other ancestors.
    pub is_last: bool,
}

/// Ancestors of the faces of a group.
pub struct GroupAncestors<'a> {
    pub pool: &'a VertexPool,
    pub ancestors: &'a Ancestors,
    /// List of each face of the group.
    pub lists: AncestorLists,
}

/// Some ancestors of a group, ascending, as a surface.
pub struct AncestorSurface {
    pub surface: OverlaySurface,
    /// Ancestor of each face.
    pub numbers: Vec<u32>,
}

impl AncestorLists {
    pub fn push(&mut self, numbers: impl IntoIterator<Item = u32>) {
        self.numbers.extend(numbers);
        self.ends.push(self.numbers.len() as u32);
    }

    pub fn get(&self, face: u32) -> &[u32] {
        let begin = if face == 0 { 0 } else { self.ends[face as usize - 1] };
        &self.numbers[begin as usize..self.ends[face as usize] as usize]
    }

    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    pub fn extend(&mut self, other: &Self) {
        let begin = self.numbers.len() as u32;
        self.ends.extend(other.ends.iter().map(|end| begin + end));
        self.numbers.extend(&other.numbers);
    }
}

impl Ancestors {
    /// Makes a face an ancestor, and returns its number.
    pub fn add(&mut self, face: PoolFace) -> u32 {
        self.faces.push(face);
        (self.faces.len() - 1) as u32
    }

    /// Counts the faces that list each ancestor.
    pub fn count_users<'a>(&mut self, lists: impl Iterator<Item = &'a AncestorLists>) {
        self.n_users.clear();
        self.n_users.resize(self.faces.len(), 0);
        lists.flat_map(|lists| &lists.numbers).for_each(|&number| self.n_users[number as usize] += 1);
    }

    /// Returns how many live faces list an ancestor.
    pub fn n_users(&self, number: u32) -> u32 {
        self.n_users[number as usize]
    }

    pub fn error(&self, number: u32) -> f64 {
        f64::from(self.faces[number as usize].error)
    }
}

impl GroupAncestors<'_> {
    pub fn triangle(&self, number: u32) -> [DVec3; 3] {
        let corners = self.ancestors.faces[number as usize].corners;
        corners.map(|v| Vec3::from(self.pool.positions[v as usize]).as_dvec3())
    }

    /// Returns how many faces of the group list each ancestor.
    pub fn count_users(&self) -> FxHashMap<u32, u32> {
        let mut counts = FxHashMap::default();
        for &number in &self.lists.numbers {
            *counts.entry(number).or_insert(0) += 1;
        }
        counts
    }

    /// Returns the surface of some ancestors.
    pub fn surface(&self, mut numbers: Vec<u32>) -> AncestorSurface {
        numbers.sort_unstable();
        numbers.dedup();
        let mut places: DistinctKeys<u32> = DistinctKeys::default();
        let mut positions = Vec::new();
        let mut number_place = |vertex: u32| {
            let number = places.number(self.pool.place(vertex));
            positions.extend((number as usize == positions.len()).then(|| self.pool.positions[vertex as usize]));
            number
        };
        let corners = numbers.iter().map(|&number| self.ancestors.faces[number as usize].corners);
        let faces: Vec<[u32; 3]> = corners.map(|corners| corners.map(&mut number_place)).collect();
        AncestorSurface { surface: OverlaySurface::new(&positions, &faces), numbers }
    }
}

impl AncestorSurface {
    /// Returns the face, of some ancestors, whose centroid is nearest to a point.
    pub fn find_nearest(&self, ancestors: &[u32], p: DVec3) -> u32 {
        let faces = ancestors.iter().filter_map(|ancestor| self.numbers.binary_search(ancestor).ok());
        let distance2 = |face: &usize| centroid(&self.surface.triangles[*face]).distance_squared(p);
        faces.min_by(|x, y| distance2(x).total_cmp(&distance2(y))).unwrap_or(0) as u32
    }
}
