//! Faces around the vertices where sheets meet.

use std::ops::Range;

use super::one_rings::{MeetingSheets, is_one_fan};
use super::union_find::UnionFind;

/// The faces at non-manifold or inconsistently wound vertices, and at neighbours of these.
pub(super) struct Surroundings {
    /// Index of each face in the mesh, ascending.
    pub numbers: Vec<u32>,
    pub faces: Vec<[u32; 3]>,
    /// Cluster of each face; faces of one cluster are connected and consistently wound.
    pub clusters: Vec<u32>,
    pub n_clusters: usize,
    vertices: Vec<u32>,
}

impl Surroundings {
    pub(super) fn new(n_vertices: usize, faces: &[[u32; 3]], meeting: &MeetingSheets) -> Self {
        let mut is_fan = vec![true; n_vertices];
        meeting.vertices.iter().chain(&meeting.opposed).for_each(|&v| is_fan[v as usize] = false);
        let mut clusters = UnionFind::new(n_vertices);
        let mut is_near = vec![false; n_vertices];
        for face in faces {
            let [a, b, c] = face.map(|v| is_fan[v as usize]);
            if a && b && c {
                clusters.union(face[0], face[1]);
                clusters.union(face[1], face[2]);
                continue;
            }
            face.iter().for_each(|&v| is_near[v as usize] = true);
            let fans: Vec<u32> = face.iter().copied().filter(|&v| is_fan[v as usize]).collect();
            fans.windows(2).for_each(|pair| _ = clusters.union(pair[0], pair[1]));
        }
        let near = (0..faces.len() as u32).filter(|&f| faces[f as usize].iter().any(|&v| is_near[v as usize]));
        let numbers: Vec<u32> = near.collect();
        let faces: Vec<[u32; 3]> = numbers.iter().map(|&f| faces[f as usize]).collect();
        let cluster = |(face, own): (&[u32; 3], u32)| {
            face.iter().find(|&&v| is_fan[v as usize]).map_or(own, |&v| clusters.find(v))
        };
        let clusters = faces.iter().zip(n_vertices as u32..).map(cluster).collect();
        let vertices = (0..n_vertices as u32).filter(|&v| is_near[v as usize]).collect();
        Self { n_clusters: n_vertices + faces.len(), numbers, faces, clusters, vertices }
    }

    /// Returns the vertices, those numbered `new` included, whose faces do not form one fan.
    pub(super) fn find_meeting_sheets(&self, new: Range<u32>) -> Vec<u32> {
        let vertices: Vec<u32> = self.vertices.iter().copied().chain(new).collect();
        let opposite = |&(_, corner): &(u32, u32)| {
            let (face, place) = (self.faces[corner as usize / 3], corner as usize % 3);
            [face[(place + 1) % 3], face[(place + 2) % 3]]
        };
        let corners = corners_at(&self.faces, &vertices);
        let fans = corners.chunk_by(|a, b| a.0 == b.0);
        let meeting = fans.filter(|fan| !is_one_fan(&mut fan.iter().map(opposite).collect::<Vec<_>>()));
        meeting.map(|fan| fan[0].0).collect()
    }
}

#[cfg(test)]
impl Surroundings {
    pub(super) fn whole(faces: &[[u32; 3]]) -> Self {
        let numbers: Vec<u32> = (0..faces.len() as u32).collect();
        let clusters = numbers.clone();
        Self { n_clusters: faces.len(), numbers, faces: faces.to_vec(), clusters, vertices: Vec::new() }
    }
}

/// Lists the corners at `vertices` (ascending) as (vertex, corner), ascending.
pub(super) fn corners_at(faces: &[[u32; 3]], vertices: &[u32]) -> Vec<(u32, u32)> {
    let mut is_one = vec![false; vertices.last().map_or(0, |&last| last as usize + 1)];
    vertices.iter().for_each(|&v| is_one[v as usize] = true);
    let all = faces.as_flattened().iter().zip(0u32..);
    let mut corners: Vec<(u32, u32)> =
        all.filter(|&(&v, _)| is_one.get(v as usize) == Some(&true)).map(|(&v, corner)| (v, corner)).collect();
    corners.sort_unstable();
    corners
}
