//! The edges of a mesh, and the quadrics of its vertices.

use glam::DVec3;
use rustc_hash::FxHashMap;

use crate::baselines::planes::face_plane;
use crate::geometry::Quadric;
use crate::geometry::triangle::area_normal_f64;

/// Weight of the planes through open edges over that of their faces, as in Open3D.
const BORDER_WEIGHT: f64 = 1.0;

/// The edges, lower end first, each once, in the order in which the faces name them, with the face that first did and
/// the number of faces.
pub(super) fn edges(faces: &[[u32; 3]]) -> Vec<([u32; 2], EdgeFaces)> {
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
pub(super) struct EdgeFaces {
    first: usize,
    count: usize,
}

/// The quadric of each vertex: planes of its faces and of its open edges.
pub(super) fn quadrics(positions: &[DVec3], faces: &[[u32; 3]]) -> Vec<Quadric> {
    let mut quadrics = vec![Quadric::default(); positions.len()];
    let corners = |face: &[u32; 3]| face.map(|v| positions[v as usize]);
    for face in faces {
        let plane = face_plane(corners(face));
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
