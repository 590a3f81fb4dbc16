//! A mesh during edge collapse.

use std::cmp::Ordering;

use glam::DVec3;

use super::quadrics::quadrics;
use crate::baselines::BaselineError;
use crate::baselines::planes::to_double;
use neural_mesh::geometry::Quadric;
use neural_mesh::geometry::triangle::area_normal_f64;
use neural_mesh::mesh::{TriMesh, compact};

// The collapse moves the edge's second end into its first.
#[derive(Clone, Copy)]
pub(super) struct CollapseCandidate {
    cost: f64,
    pub(super) edge: [u32; 2],
    // Numbers of changes of both ends at the time of pricing.
    changes: [u32; 2],
    place: DVec3,
}

impl Ord for CollapseCandidate {
    fn cmp(&self, other: &Self) -> Ordering {
        self.cost.total_cmp(&other.cost).then_with(|| (self.edge, self.changes).cmp(&(other.edge, other.changes)))
    }
}

impl PartialOrd for CollapseCandidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for CollapseCandidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for CollapseCandidate {}

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
        let [v, w] = edge.map(|v| v as usize);
        let quadric = self.quadrics[v] + self.quadrics[w];
        let ends = [self.positions[v], self.positions[w]];
        let (place, cost) = quadric.minimum().unwrap_or_else(|| best_candidate_point(&quadric, ends));
        CollapseCandidate { cost, edge, changes: [self.changes[v], self.changes[w]], place }
    }

    pub(super) fn is_current(&self, candidate: &CollapseCandidate) -> bool {
        candidate.edge.map(|v| self.changes[v as usize]) == candidate.changes
    }

    pub(super) fn flips_face(&self, candidate: &CollapseCandidate) -> bool {
        let turns = |&f: &u32| {
            let face = self.faces[f as usize];
            let moved = |v: u32| if candidate.edge.contains(&v) { candidate.place } else { self.positions[v as usize] };
            let before = area_normal_f64(face.map(|v| self.positions[v as usize]));
            !candidate.edge.iter().all(|v| face.contains(v)) && before.dot(area_normal_f64(face.map(moved))) < 0.0
        };
        candidate.edge.iter().any(|&v| self.faces_of[v as usize].iter().any(turns))
    }

    pub(super) fn collapse(&mut self, candidate: &CollapseCandidate) {
        let [kept, gone] = candidate.edge;
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
        self.positions[kept as usize] = candidate.place;
        self.quadrics[kept as usize] = self.quadrics[kept as usize] + self.quadrics[gone as usize];
        candidate.edge.iter().for_each(|&v| self.changes[v as usize] += 1);
    }

    pub(super) fn neighbours(&self, v: u32) -> Vec<u32> {
        let around = self.faces_of[v as usize].iter().flat_map(|&f| self.faces[f as usize]);
        let mut neighbours: Vec<u32> = around.filter(|&w| w != v).collect();
        neighbours.sort_unstable();
        neighbours.dedup();
        neighbours
    }

    pub(super) fn into_mesh(self) -> Result<TriMesh, BaselineError> {
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
