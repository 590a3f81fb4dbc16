//! A mesh during edge collapse.

use glam::DVec3;

use super::quadrics::quadrics;
use crate::baselines::points::to_double;
use anyhow::Result;
use neural_mesh::geometry::Quadric;
use neural_mesh::geometry::triangle::area_normal_f64;
use neural_mesh::mesh::{TriMesh, compact};

/// A collapse of an edge's second end into its first, cheapest first.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct CollapseCandidate {
    // Bits of the cost, in the order of the numbers.
    cost: i64,
    pub(super) edge: [u32; 2],
    // Numbers of changes of both ends at the time of pricing.
    changes: [u32; 2],
}

pub(super) struct CollapsingMesh {
    positions: Vec<DVec3>,
    quadrics: Vec<Quadric>,
    faces: Vec<[u32; 3]>,
    faces_of: Vec<Vec<u32>>,
    changes: Vec<u32>,
    pub(super) n_faces: usize,
}

impl CollapsingMesh {
    pub(super) fn new(mesh: &TriMesh) -> Self {
        let positions = to_double(mesh.positions());
        let faces = mesh.faces().to_vec();
        let mut faces_of = vec![Vec::new(); positions.len()];
        for (f, face) in (0..).zip(&faces) {
            face.iter().for_each(|&v| faces_of[v as usize].push(f));
        }
        let quadrics = quadrics(mesh);
        let changes = vec![0; positions.len()];
        Self { positions, quadrics, n_faces: faces.len(), faces, faces_of, changes }
    }

    pub(super) fn price_collapse(&self, edge: [u32; 2]) -> CollapseCandidate {
        let bits = self.placement(edge).1.to_bits() as i64;
        // Larger bits of negative numbers are smaller numbers.
        let cost = bits ^ (((bits >> 63) as u64) >> 1) as i64;
        CollapseCandidate { cost, edge, changes: edge.map(|v| self.changes[v as usize]) }
    }

    /// Returns the point to which an edge collapses, and its cost.
    fn placement(&self, edge: [u32; 2]) -> (DVec3, f64) {
        let [v, w] = edge.map(|v| v as usize);
        let quadric = self.quadrics[v] + self.quadrics[w];
        quadric.minimum().unwrap_or_else(|| best_candidate_point(&quadric, [self.positions[v], self.positions[w]]))
    }

    /// Collapses the edge of a candidate, unless an end changed after it was priced, or a face would turn over.
    pub(super) fn try_collapse(&mut self, candidate: &CollapseCandidate) -> bool {
        let edge = candidate.edge;
        if edge.map(|v| self.changes[v as usize]) != candidate.changes {
            return false;
        }
        // The ends are as they were, and so is the placement.
        let place = self.placement(edge).0;
        let turns_none = !self.flips_face(edge, place);
        if turns_none {
            self.collapse(edge, place);
        }
        turns_none
    }

    fn flips_face(&self, edge: [u32; 2], place: DVec3) -> bool {
        let turns = |&f: &u32| {
            let face = self.faces[f as usize];
            let moved = |v: u32| if edge.contains(&v) { place } else { self.positions[v as usize] };
            let before = area_normal_f64(face.map(|v| self.positions[v as usize]));
            !edge.iter().all(|v| face.contains(v)) && before.dot(area_normal_f64(face.map(moved))) < 0.0
        };
        edge.iter().any(|&v| self.faces_of[v as usize].iter().any(turns))
    }

    fn collapse(&mut self, [kept, gone]: [u32; 2], place: DVec3) {
        for f in std::mem::take(&mut self.faces_of[gone as usize]) {
            let face = self.faces[f as usize];
            if face.contains(&kept) {
                face.iter().for_each(|&v| self.faces_of[v as usize].retain(|&other| other != f));
                self.n_faces -= 1;
            } else {
                self.faces[f as usize] = face.map(|v| if v == gone { kept } else { v });
                self.faces_of[kept as usize].push(f);
            }
        }
        self.positions[kept as usize] = place;
        self.quadrics[kept as usize] = self.quadrics[kept as usize] + self.quadrics[gone as usize];
        [kept, gone].iter().for_each(|&v| self.changes[v as usize] += 1);
    }

    pub(super) fn neighbours(&self, v: u32) -> Vec<u32> {
        let around = self.faces_of[v as usize].iter().flat_map(|&f| self.faces[f as usize]);
        let mut neighbours: Vec<u32> = around.filter(|&w| w != v).collect();
        neighbours.sort_unstable();
        neighbours.dedup();
        neighbours
    }

    pub(super) fn into_mesh(self) -> Result<TriMesh> {
        let is_left = |&(f, face): &(usize, &[u32; 3])| self.faces_of[face[0] as usize].contains(&(f as u32));
        let faces = self.faces.iter().enumerate().filter(is_left).map(|(_, face)| *face).collect();
        let positions: Vec<[f32; 3]> = self.positions.iter().map(|p| p.as_vec3().to_array()).collect();
        Ok(compact(&positions, faces)?.0)
    }
}

fn best_candidate_point(quadric: &Quadric, [a, b]: [DVec3; 2]) -> (DVec3, f64) {
    let places = [a, b, a.midpoint(b)].map(|place| (place, quadric.value(place)));
    let better = |best: (DVec3, f64), other: (DVec3, f64)| if other.1 < best.1 { other } else { best };
    better(better(places[0], places[1]), places[2])
}
