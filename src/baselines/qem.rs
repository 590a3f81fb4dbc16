//! Edge collapse by quadric error with optimal placement (Garland and Heckbert 1997).
//!
//! As the paper has it and as Open3D runs it: planes of faces weighed by area, planes through open edges at right angles
//! to their face with the same weight, the vertex of a collapsed edge at the minimum of both quadrics or else at the best
//! of its ends and its middle, no collapse that turns a face over. No test of the topology: pinches may appear.
//!
//! Ours, since no kept crate has it: `baby_shark` and `alum` place vertices at ends or collapse by other costs,
//! `meshopt` keeps to the vertices of the input.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::BaselineError;
use crate::geometry::Quadric;
use crate::geometry::triangle::area_normal_f64;
use crate::mesh::{TriMesh, compact};

/// Weight of the planes through open edges over that of their faces, as in Open3D.
const BORDER_WEIGHT: f64 = 1.0;

/// Collapses the cheapest edges until at most `n_faces` are left.
pub(super) fn qem(mesh: &TriMesh, n_faces: usize) -> Result<TriMesh, BaselineError> {
    let mut surface = Surface::new(mesh);
    let mut queue: BinaryHeap<Reverse<Candidate>> =
        edges(mesh.faces()).into_iter().map(|(edge, _)| Reverse(surface.candidate(edge))).collect();
    while surface.n_faces > n_faces {
        let Some(Reverse(candidate)) = queue.pop() else { break };
        if surface.is_current(&candidate) && !surface.turns_a_face(&candidate) {
            surface.collapse(&candidate);
            let kept = candidate.edge[0];
            queue.extend(surface.neighbours(kept).into_iter().map(|v| Reverse(surface.candidate([kept, v]))));
        }
    }
    surface.into_mesh()
}

/// An edge that may go: its second end into its first.
#[derive(Clone, Copy)]
struct Candidate {
    cost: f64,
    edge: [u32; 2],
    /// How often each end had changed when the cost was found.
    changes: [u32; 2],
    place: DVec3,
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        self.cost.total_cmp(&other.cost).then_with(|| (self.edge, self.changes).cmp(&(other.edge, other.changes)))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Candidate {}

/// A mesh while its edges collapse.
struct Surface {
    positions: Vec<DVec3>,
    quadrics: Vec<Quadric>,
    faces: Vec<[u32; 3]>,
    /// Faces around each vertex that are still there; empty for vertices that went.
    faces_of: Vec<Vec<u32>>,
    changes: Vec<u32>,
    n_faces: usize,
}

impl Surface {
    fn new(mesh: &TriMesh) -> Self {
        let positions: Vec<DVec3> = mesh.positions().iter().map(|p| DVec3::from_array(p.map(f64::from))).collect();
        let faces = mesh.faces().to_vec();
        let mut faces_of = vec![Vec::new(); positions.len()];
        for (f, face) in (0..).zip(&faces) {
            face.iter().for_each(|&v| faces_of[v as usize].push(f));
        }
        let quadrics = quadrics(&positions, &faces);
        let changes = vec![0; positions.len()];
        Self { positions, quadrics, n_faces: faces.len(), faces, faces_of, changes }
    }

    fn candidate(&self, edge: [u32; 2]) -> Candidate {
        let [v, w] = edge.map(|v| v as usize);
        let quadric = self.quadrics[v] + self.quadrics[w];
        let ends = [self.positions[v], self.positions[w]];
        let (place, cost) = quadric.minimum().unwrap_or_else(|| best_of_ends(&quadric, ends));
        Candidate { cost, edge, changes: [self.changes[v], self.changes[w]], place }
    }

    fn is_current(&self, candidate: &Candidate) -> bool {
        candidate.edge.map(|v| self.changes[v as usize]) == candidate.changes
    }

    /// Whether a face that stays would look the other way.
    fn turns_a_face(&self, candidate: &Candidate) -> bool {
        let turns = |&f: &u32| {
            let face = self.faces[f as usize];
            let moved = |v: u32| if candidate.edge.contains(&v) { candidate.place } else { self.positions[v as usize] };
            let before = area_normal_f64(face.map(|v| self.positions[v as usize]));
            !candidate.edge.iter().all(|v| face.contains(v)) && before.dot(area_normal_f64(face.map(moved))) < 0.0
        };
        candidate.edge.iter().any(|&v| self.faces_of[v as usize].iter().any(turns))
    }

    fn collapse(&mut self, candidate: &Candidate) {
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

    /// The vertices that share a face with `v`, ascending.
    fn neighbours(&self, v: u32) -> Vec<u32> {
        let around = self.faces_of[v as usize].iter().flat_map(|&f| self.faces[f as usize]);
        let mut neighbours: Vec<u32> = around.filter(|&w| w != v).collect();
        neighbours.sort_unstable();
        neighbours.dedup();
        neighbours
    }

    /// The faces that are left, their vertices in single precision.
    fn into_mesh(self) -> Result<TriMesh, BaselineError> {
        let is_left = |&(f, face): &(usize, &[u32; 3])| self.faces_of[face[0] as usize].contains(&(f as u32));
        let faces = self.faces.iter().enumerate().filter(is_left).map(|(_, face)| *face).collect();
        let positions: Vec<[f32; 3]> = self.positions.iter().map(|p| p.as_vec3().to_array()).collect();
        Ok(compact(&positions, faces)?.0)
    }
}

/// The cheapest of both ends and the middle, and its cost.
fn best_of_ends(quadric: &Quadric, [a, b]: [DVec3; 2]) -> (DVec3, f64) {
    let places = [a, b, a.midpoint(b)].map(|place| (place, quadric.value(place)));
    let better = |best: (DVec3, f64), other: (DVec3, f64)| if other.1 < best.1 { other } else { best };
    better(better(places[0], places[1]), places[2])
}

/// The edges, lower end first, each once, in the order in which the faces name them, with the face that first did and
/// the number of faces.
fn edges(faces: &[[u32; 3]]) -> Vec<([u32; 2], EdgeFaces)> {
    let mut at: FxHashMap<[u32; 2], usize> = FxHashMap::default();
    let mut edges: Vec<([u32; 2], EdgeFaces)> = Vec::with_capacity(2 * faces.len());
    for (face, &[a, b, c]) in faces.iter().enumerate() {
        for [v, w] in [[a, b], [b, c], [c, a]] {
            let edge = [v.min(w), v.max(w)];
            let place = *at.entry(edge).or_insert(edges.len());
            if place == edges.len() {
                edges.push((edge, EdgeFaces { first: face, count: 0 }));
            }
            edges[place].1.count += 1;
        }
    }
    edges
}

/// The faces at an edge.
struct EdgeFaces {
    first: usize,
    count: usize,
}

/// The quadric of each vertex: planes of its faces and of its open edges.
fn quadrics(positions: &[DVec3], faces: &[[u32; 3]]) -> Vec<Quadric> {
    let mut quadrics = vec![Quadric::default(); positions.len()];
    let corners = |face: &[u32; 3]| face.map(|v| positions[v as usize]);
    for face in faces {
        let normal = area_normal_f64(corners(face));
        let plane = Quadric::of_plane(normal.normalize_or_zero(), positions[face[0] as usize], 0.5 * normal.length());
        face.iter().for_each(|&v| quadrics[v as usize] += plane);
    }
    for ([v, w], at) in edges(faces).into_iter().filter(|(_, at)| at.count == 1) {
        let normal = area_normal_f64(corners(&faces[at.first]));
        let along = positions[w as usize] - positions[v as usize];
        let across = normal.cross(along).normalize_or_zero();
        let plane = Quadric::of_plane(across, positions[v as usize], BORDER_WEIGHT * 0.5 * normal.length());
        [v, w].iter().for_each(|&v| quadrics[v as usize] += plane);
    }
    quadrics
}
