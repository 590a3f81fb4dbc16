//! Removal of faces that keep holes from being closed.

use super::manifold_faces::{ManifoldFaces, NO_FACE, edge_key, edges_of};
use rustc_hash::FxHashMap;

/// Components of fewer faces are removed, unless they are closed and no other is larger.
const FEWEST_FACES: usize = 8;

/// Faces that stay at a vertex that the boundary passes more than once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AtPinch {
    /// The fan with most faces.
    LargestFan,
    /// No face.
    Nothing,
}

impl ManifoldFaces<'_> {
    /// Removes faces at pinched vertices, and small components; returns how many.
    pub fn remove_pinches(&mut self, kept: AtPinch) -> usize {
        let mut is_removed = self.mark_small_components();
        for (v, faces) in self.faces_at_pinches() {
            let fans = self.fans(v, &faces);
            let largest = (0..fans.len()).rev().max_by_key(|&i| fans[i].len()).filter(|_| kept == AtPinch::LargestFan);
            let others = (0..fans.len()).filter(|&i| Some(i) != largest);
            others.for_each(|i| fans[i].iter().for_each(|&face| is_removed[face as usize] = true));
        }
        let n_removed = is_removed.iter().filter(|removed| **removed).count();
        if n_removed > 0 {
            let mut rest = Self::new(self.points);
            let wound = self.list_wound_faces();
            let stays = wound.into_iter().zip(is_removed).filter(|(_, is_removed)| !is_removed);
            stays.for_each(|(face, _)| _ = rest.add(face));
            *self = rest;
        }
        n_removed
    }

    fn mark_small_components(&mut self) -> Vec<bool> {
        let components = self.components();
        let (mut sizes, mut is_open) = (vec![0; components.len()], vec![false; components.len()]);
        components.iter().for_each(|&root| sizes[root as usize] += 1);
        for faces in self.at_edges.values().filter(|faces| faces[1] == NO_FACE) {
            is_open[components[faces[0] as usize] as usize] = true;
        }
        let largest = sizes.iter().copied().max().unwrap_or(0);
        let is_small = |root: usize| sizes[root] < FEWEST_FACES && (is_open[root] || sizes[root] < largest);
        components.iter().map(|&root| is_small(root as usize)).collect()
    }

    fn faces_at_pinches(&self) -> FxHashMap<u32, Vec<u32>> {
        let is_pinched: Vec<bool> = (0..self.points.len() as u32).map(|v| self.is_pinched(v)).collect();
        let mut at_pinches: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
        for (number, face) in (0..).zip(&self.faces) {
            let pinched = face.iter().filter(|&&v| is_pinched[v as usize]);
            pinched.for_each(|&v| at_pinches.entry(v).or_default().push(number));
        }
        at_pinches
    }

    /// Groups the faces at a vertex into fans, in which they share edges at it.
    fn fans(&self, v: u32, faces: &[u32]) -> Vec<Vec<u32>> {
        let mut fans: Vec<Vec<u32>> = Vec::new();
        for &first in faces {
            if fans.iter().any(|fan| fan.contains(&first)) {
                continue;
            }
            let mut fan = vec![first];
            let mut at = 0;
            while let Some(&face) = fan.get(at) {
                let edges = edges_of(self.faces[face as usize]).into_iter().filter(|edge| edge.contains(&v));
                for other in edges.flat_map(|edge| self.at_edges[&edge_key(edge)]) {
                    if other != NO_FACE && !fan.contains(&other) {
                        fan.push(other);
                    }
                }
                at += 1;
            }
            fans.push(fan);
        }
        fans
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn the_larger_fan_stays_or_none() {
        // Two fans of two faces and of one at vertex 0, in a component that is large enough.
        let grid = shapes::grid(6, 6);
        let centre = grid.faces().iter().map(|face| face[0]).max().unwrap() / 2;
        let around: Vec<[u32; 3]> = grid.faces().iter().filter(|face| face.contains(&centre)).copied().collect();
        let share = |a: &[u32; 3], b: &[u32; 3]| a.iter().filter(|v| b.contains(v)).count();
        let lone = around[0];
        // Without the neighbours of one face around the centre, it is a fan of its own there.
        let faces: Vec<[u32; 3]> =
            grid.faces().iter().filter(|face| !(face.contains(&centre) && share(face, &lone) == 2)).copied().collect();
        for (kept, n_removed) in [(AtPinch::LargestFan, 1), (AtPinch::Nothing, around.len() - 2)] {
            let mut manifold = ManifoldFaces::new(grid.positions());
            assert!(faces.iter().all(|&face| manifold.add(face)) && manifold.is_pinched(centre));
            assert_eq!(manifold.remove_pinches(kept), n_removed);
            assert!(!manifold.is_pinched(centre));
            assert_eq!(manifold.remove_pinches(kept), 0);
        }
    }

    #[test]
    fn a_small_component_goes_unless_it_is_closed_and_alone() {
        let sphere = shapes::icosphere(0);
        let mut manifold = ManifoldFaces::new(sphere.positions());
        sphere.faces()[..7].iter().for_each(|&face| assert!(manifold.add(face)));
        assert_eq!(manifold.remove_pinches(AtPinch::LargestFan), 7);
        let tetrahedron = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]];
        assert!(tetrahedron.iter().all(|&face| manifold.add(face)));
        assert_eq!(manifold.remove_pinches(AtPinch::LargestFan), 0);
        let points = [sphere.positions(), shapes::icosphere(1).positions()].concat();
        let mut manifold = ManifoldFaces::new(&points);
        let larger = shapes::icosphere(1);
        tetrahedron.iter().for_each(|&face| assert!(manifold.add(face)));
        larger.faces().iter().for_each(|face| assert!(manifold.add(face.map(|v| v + 12))));
        assert_eq!(manifold.remove_pinches(AtPinch::LargestFan), 4);
    }
}
