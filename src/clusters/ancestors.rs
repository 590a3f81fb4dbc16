//! Ancestors: faces of an earlier level, against which the results of several levels are proved.
//!
//! Bounds that are proved from level to level add up, and errors about double with each level. Against an earlier level
//! fewer of them add up. Each point of the input belongs to one ancestor and, at each level, to one face. A face lists
//! the ancestors of all points that belong to it, and perhaps some more.

use glam::DVec3;

use super::overlay_surface::OverlaySurface;
use super::vertices::{PoolFace, VertexPool};
use crate::mesh::DistinctKeys;

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
}

/// Ancestors of the faces of a group.
pub struct GroupAncestors<'a> {
    pub pool: &'a VertexPool,
    pub ancestors: &'a Ancestors,
    /// List of each face of the group.
    pub lists: AncestorLists,
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

    pub fn error(&self, number: u32) -> f64 {
        f64::from(self.faces[number as usize].error)
    }
}

impl GroupAncestors<'_> {
    pub fn triangle(&self, number: u32) -> [DVec3; 3] {
        let corners = self.ancestors.faces[number as usize].corners;
        corners.map(|v| DVec3::from(self.pool.positions[v as usize].map(f64::from)))
    }

    /// Returns the group's ancestors, sorted, and whether all faces that list each are in the group.
    pub fn distinct(&self) -> (Vec<u32>, Vec<bool>) {
        let mut numbers = self.lists.numbers.clone();
        numbers.sort_unstable();
        let runs = numbers.chunk_by(|x, y| x == y);
        let is_inside = |run: &[u32]| self.ancestors.n_users[run[0] as usize] as usize == run.len();
        runs.map(|run| (run[0], is_inside(run))).unzip()
    }

    /// Returns the surface of some ancestors.
    pub fn surface(&self, numbers: &[u32]) -> OverlaySurface {
        let mut places: DistinctKeys<u32> = DistinctKeys::default();
        let mut positions = Vec::new();
        let mut number = |vertex: u32| {
            let number = places.number(self.pool.place(vertex));
            positions.extend((number as usize == positions.len()).then(|| self.pool.positions[vertex as usize]));
            number
        };
        let faces: Vec<[u32; 3]> =
            numbers.iter().map(|&it| self.ancestors.faces[it as usize].corners.map(&mut number)).collect();
        OverlaySurface::new(&positions, &faces)
    }
}
