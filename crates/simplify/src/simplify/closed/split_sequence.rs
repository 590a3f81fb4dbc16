//! Vertex splits that lead from the smallest mesh to the whole one (Hoppe 1996, "Progressive meshes").
//!
//! Vertices are named by rank: the last one that a merge removed comes first, so the vertices of each level are the
//! first ones. Faces are sorted by the split that makes them, so the faces of each level are the first ones, too.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use glam::Vec3;

use crate::linalg::Rows;
use crate::mesh::pulse::Pulse;
use crate::parallel;

use super::collapse::RecordedMerge;

const CHUNK: usize = 1 << 14;

/// Positions that a split restores.
#[derive(Clone, Copy)]
struct VertexSplit {
    /// Vertex that is split; the vertex itself if it belongs to the smallest mesh.
    parent: u32,
    /// Position of the parent after the split, at unit size.
    parent_position: Vec3,
    /// Position of the new vertex, at unit size.
    position: Vec3,
}

pub struct SplitSequence {
    /// VertexSplit that makes each vertex, n_vertices.
    splits: Vec<VertexSplit>,
    /// Vertex of the surface, n_vertices.
    vertices: Vec<u32>,
    /// True where the parent had moved to the vertex's place; n_vertices.
    takes_place: Vec<bool>,
    /// Number of vertices of the smallest mesh.
    n_roots: usize,
    /// Number of faces of each level, n_vertices + 1.
    face_ends: Vec<u32>,
    /// Corners of each face when it is made, n_faces x 3.
    faces: Vec<[u32; 3]>,
    /// Corners, 3 x face + k, that move from the parent to each new vertex, n_vertices.
    moves: Rows<u32>,
}

/// Rank and parent of a vertex of the surface.
#[derive(Clone, Copy)]
struct Link {
    rank: u32,
    parent: u32,
}

impl SplitSequence {
    /// Reverses merges of a surface's vertices; `None` if a merge has a vertex that is removed or out of range.
    pub fn new(pulse: Pulse, positions: &[Vec3], faces: &[[u32; 3]], merges: &[RecordedMerge]) -> Option<Self> {
        Self::with_most_moves(pulse, positions, faces, merges, u64::MAX)
    }

    /// Reverses merges; also returns `None` if corners of faces move more than `most_moves` times.
    pub fn with_most_moves(
        pulse: Pulse,
        positions: &[Vec3],
        faces: &[[u32; 3]],
        merges: &[RecordedMerge],
        most_moves: u64,
    ) -> Option<Self> {
        let (links, vertices) = link_vertices(positions.len(), merges)?;
        let n_roots = vertices.len() - merges.len();
        pulse.beat(0);
        let mut sequence = Self {
            splits: reverse_merges(positions, merges, &links, &vertices),
            takes_place: vec![false; vertices.len()],
            n_roots,
            vertices,
            face_ends: Vec::new(),
            faces: Vec::new(),
            moves: Rows::new(0, std::iter::empty()),
        };
        for (takes_place, merge) in sequence.takes_place.iter_mut().rev().zip(merges) {
            *takes_place = merge.takes_removed_place;
        }
        pulse.beat(0);
        let are_bounded = most_moves == u64::MAX || are_moves_within(most_moves, faces, n_roots as u32, &links);
        are_bounded.then(|| {
            sequence.sort_faces(pulse, faces, &links);
            sequence
        })
    }

    pub fn n_vertices(&self) -> usize {
        self.vertices.len()
    }

    /// Returns the number of vertices of the smallest level.
    pub fn n_roots(&self) -> usize {
        self.n_roots
    }

    /// Returns the number of faces at a number of vertices.
    pub fn n_faces(&self, n_vertices: usize) -> usize {
        self.face_ends[n_vertices] as usize
    }

    /// Returns the faces that the split of this vertex makes; for a vertex of the smallest mesh, none.
    pub fn new_faces(&self, vertex: usize) -> usize {
        if vertex < self.n_roots { 0 } else { (self.face_ends[vertex + 1] - self.face_ends[vertex]) as usize }
    }

    /// Returns the vertex of the surface with each rank, n_vertices.
    pub fn vertices(&self) -> &[u32] {
        &self.vertices
    }

    pub fn parent(&self, vertex: usize) -> u32 {
        self.splits[vertex].parent
    }

    pub fn takes_place(&self, vertex: usize) -> bool {
        self.takes_place[vertex]
    }

    /// Returns the number of vertices of the largest level within both limits, or else of the smallest.
    pub fn largest_within(&self, n_vertices: usize, n_faces: usize) -> usize {
        let within_faces = self.face_ends.partition_point(|&end| end as usize <= n_faces).saturating_sub(1);
        within_faces.min(n_vertices).clamp(self.n_roots, self.n_vertices())
    }

    /// Returns the positions of the first `n` vertices in a mesh of `n` vertices, at unit size.
    pub fn positions(&self, n: usize) -> Vec<Vec3> {
        let mut positions = Vec::with_capacity(n);
        for split in &self.splits[..n] {
            // A vertex of the smallest mesh is its own parent and writes its position twice.
            positions.push(split.position);
            positions[split.parent as usize] = split.parent_position;
        }
        positions
    }

    /// Returns the faces of a mesh of `n` vertices.
    pub fn faces(&self, n: usize) -> Vec<[u32; 3]> {
        let mut faces = self.faces[..self.face_ends[n] as usize].to_vec();
        let corners = faces.as_flattened_mut();
        for vertex in self.n_roots..n {
            self.moves.row(vertex).iter().for_each(|&corner| corners[corner as usize] = vertex as u32);
        }
        faces
    }

    /// Returns the merges, the first one first; keys are not kept.
    pub fn merges(&self) -> impl Iterator<Item = RecordedMerge> {
        let mut positions = self.positions(self.n_roots);
        // Splits run backwards, so the merged positions are collected before.
        let mut merged = Vec::with_capacity(self.n_vertices() - self.n_roots);
        for split in &self.splits[self.n_roots..] {
            merged.push(std::mem::replace(&mut positions[split.parent as usize], split.parent_position));
            positions.push(split.position);
        }
        let ranks = (self.n_roots..self.n_vertices()).rev();
        ranks.zip(merged.into_iter().rev()).map(|(rank, position)| RecordedMerge {
            kept: self.vertices[self.splits[rank].parent as usize],
            removed: self.vertices[rank],
            position,
            key: 0.0,
            takes_removed_place: self.takes_place[rank],
        })
    }

    fn sort_faces(&mut self, pulse: Pulse, faces: &[[u32; 3]], links: &[Link]) {
        let n = self.vertices.len();
        let n_roots = self.n_roots as u32;
        let mut face_ends = vec![0; n + 1];
        // Counting sort by the split that makes each face; faces of the smallest mesh count for its last vertex.
        let made = pulse.map(faces, |&face| follow_corners(face, n_roots, links, |_, _| ()));
        made.iter().for_each(|(birth, _)| face_ends[*birth as usize + 1] += 1);
        (0..n).for_each(|vertex| face_ends[vertex + 1] += face_ends[vertex]);
        let mut next = face_ends.clone();
        let slot_of = |&(birth, _): &(u32, [u32; 3])| {
            next[birth as usize] += 1;
            next[birth as usize] - 1
        };
        let slots: Vec<u32> = made.iter().map(slot_of).collect();
        self.faces = vec![[0; 3]; faces.len()];
        slots.iter().zip(&made).for_each(|(&slot, (_, corners))| self.faces[slot as usize] = *corners);
        // Each chunk of faces lists its moves; the lists are then sorted by the vertex that moves.
        let moves_of = |(faces, slots): (&[[u32; 3]], &[u32])| {
            let mut moves: Vec<(u32, u32)> = Vec::with_capacity(3 * faces.len());
            for (&face, &slot) in faces.iter().zip(slots) {
                follow_corners(face, n_roots, links, |vertex, k| moves.push((vertex, 3 * slot + k)));
            }
            moves
        };
        let moves = parallel::each(faces.chunks(CHUNK).zip(slots.chunks(CHUNK)), moves_of);
        self.moves = Rows::new(n, moves.iter().flatten().copied());
        self.face_ends = face_ends;
    }
}

/// Follows a face's corners through the merges until it vanishes or all corners are of the smallest mesh.
///
/// Calls `visit` with each vertex that leaves the face and its corner. Returns the vertex whose split makes the face,
/// and the corners then, both by rank.
#[inline(always)]
fn follow_corners(
    mut corners: [u32; 3],
    n_roots: u32,
    links: &[Link],
    mut visit: impl FnMut(u32, u32),
) -> (u32, [u32; 3]) {
    let mut at = corners.map(|v| links[v as usize]);
    loop {
        let ranks = at.map(|link| link.rank);
        // The corner that is removed first has the largest rank.
        let k = if ranks[0] > ranks[1].max(ranks[2]) { 0 } else { 1 + usize::from(ranks[2] > ranks[1]) };
        if ranks[k] < n_roots {
            return (n_roots - 1, ranks);
        }
        let parent = at[k].parent;
        if corners.contains(&parent) {
            return (ranks[k], ranks);
        }
        visit(ranks[k], k as u32);
        corners[k] = parent;
        at[k] = links[parent as usize];
    }
}

/// Returns whether the corners of all faces move at most so often; takes no memory.
fn are_moves_within(most: u64, faces: &[[u32; 3]], n_roots: u32, links: &[Link]) -> bool {
    let n_moves = AtomicU64::new(0);
    !parallel::any(faces.len(), CHUNK, |face| {
        let mut n = 0;
        follow_corners(faces[face], n_roots, links, |_, _| n += 1);
        n_moves.fetch_add(n, Relaxed) + n > most
    })
}

/// Returns rank and parent of each vertex, and the vertex of each rank.
fn link_vertices(n: usize, merges: &[RecordedMerge]) -> Option<(Vec<Link>, Vec<u32>)> {
    let n_roots = n.checked_sub(merges.len()).filter(|n_roots| *n_roots > 0)?;
    const NONE: u32 = u32::MAX;
    let mut links = vec![Link { rank: NONE, parent: NONE }; n];
    let mut vertices = vec![0; n];
    for (rank, merge) in (n_roots..n).rev().zip(merges) {
        // Neither end may have been removed before.
        let remains = |v: u32| links.get(v as usize).is_some_and(|link| link.rank == NONE);
        if merge.kept == merge.removed || !remains(merge.kept) || !remains(merge.removed) {
            return None;
        }
        links[merge.removed as usize] = Link { rank: rank as u32, parent: merge.kept };
        vertices[rank] = merge.removed;
    }
    let left = (0u32..).zip(&mut links).filter(|(_, link)| link.rank == NONE);
    for (rank, (v, link)) in left.enumerate() {
        *link = Link { rank: rank as u32, parent: v };
        vertices[rank] = v;
    }
    Some((links, vertices))
}

fn reverse_merges(positions: &[Vec3], merges: &[RecordedMerge], links: &[Link], vertices: &[u32]) -> Vec<VertexSplit> {
    let mut positions = positions.to_vec();
    let mut splits: Vec<VertexSplit> = Vec::with_capacity(vertices.len());
    for merge in merges {
        let kept = &mut positions[merge.kept as usize];
        let parent_position = std::mem::replace(kept, merge.position);
        let parent = links[merge.kept as usize].rank;
        splits.push(VertexSplit { parent, parent_position, position: positions[merge.removed as usize] });
    }
    splits.extend((0..vertices.len() - merges.len()).rev().map(|rank| {
        let position = positions[vertices[rank] as usize];
        VertexSplit { parent: rank as u32, parent_position: position, position }
    }));
    splits.reverse();
    splits
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{TriMesh, shapes, topology};
    use crate::simplify::closed::collapse::Collapse;
    use crate::simplify::closed::faces_around::smallest_first;
    use crate::simplify::closed::prepare::surface::PreparedSurface;
    use crate::simplify::limits::Limit;

    fn record(surface: &PreparedSurface) -> Vec<RecordedMerge> {
        let mut collapse = Collapse::new(Pulse::NONE, surface).with_recording();
        collapse.run(Limit::from_vertices(1));
        let mut merges = collapse.take_recording();
        merges.sort_by(|x, y| x.key.total_cmp(&y.key));
        merges
    }

    fn sequence(surface: &PreparedSurface) -> (Vec<RecordedMerge>, SplitSequence) {
        let merges = record(surface);
        let sequence = SplitSequence::new(Pulse::NONE, &surface.positions, &surface.faces, &merges).unwrap();
        (merges, sequence)
    }

    fn shapes() -> [TriMesh; 4] {
        [
            shapes::wavy_sphere(3, 6.0),
            shapes::open_cylinder(24, 12),
            shapes::klein_bottle(20, 12),
            shapes::torus(30, 12, 1.0, 0.4),
        ]
    }

    #[test]
    fn levels_are_those_of_merges_made_one_by_one() {
        for mesh in shapes() {
            let surface = PreparedSurface::new(&mesh, Pulse::NONE);
            let (merges, sequence) = sequence(&surface);
            let mut positions = surface.positions.clone();
            let mut merged: Vec<u32> = (0..positions.len() as u32).collect();
            for (i, merge) in merges.iter().enumerate() {
                positions[merge.kept as usize] = merge.position;
                merged.iter_mut().filter(|v| **v == merge.removed).for_each(|v| *v = merge.kept);
                let n = positions.len() - i - 1;
                let faces = surface.faces.iter().map(|face| face.map(|v| merged[v as usize]));
                let naive: Vec<[u32; 3]> =
                    faces.filter(|[a, b, c]| a != b && b != c && c != a).map(smallest_first).collect();
                let named = |face: [u32; 3]| smallest_first(face.map(|v| sequence.vertices()[v as usize]));
                let mut found: Vec<[u32; 3]> = sequence.faces(n).into_iter().map(named).collect();
                let mut naive_sorted = naive.clone();
                found.sort_unstable();
                naive_sorted.sort_unstable();
                assert_eq!(found, naive_sorted, "{n}");
                let at = sequence.positions(n);
                assert!((0..n).all(|v| at[v] == positions[sequence.vertices()[v] as usize]), "{n}");
            }
        }
    }

    #[test]
    fn every_level_keeps_the_topology() {
        for mesh in shapes() {
            let surface = PreparedSurface::new(&mesh, Pulse::NONE);
            let (merges, sequence) = sequence(&surface);
            assert!(merges.is_sorted_by(|x, y| x.key <= y.key));
            let whole = topology(&mesh);
            for n in sequence.n_roots()..sequence.n_vertices() {
                let positions = sequence.positions(n).iter().map(|p| p.to_array()).collect();
                let found = topology(&TriMesh::new(positions, sequence.faces(n)).unwrap());
                assert_eq!(found.non_manifold_edges + found.non_manifold_vertices + found.unreferenced_vertices, 0);
                assert_eq!((found.euler, found.boundary_loops), (whole.euler, whole.boundary_loops), "{n}");
                assert_eq!((found.components, found.orientable), (whole.components, whole.orientable), "{n}");
            }
        }
    }

    #[test]
    fn merges_come_back_and_impossible_ones_are_refused() {
        let mesh = shapes::wavy_sphere(2, 6.0);
        let surface = PreparedSurface::new(&mesh, Pulse::NONE);
        let (merges, sequence) = sequence(&surface);
        let without_keys: Vec<RecordedMerge> =
            merges.iter().map(|merge| RecordedMerge { key: 0.0, ..*merge }).collect();
        assert_eq!(sequence.merges().collect::<Vec<_>>(), without_keys);
        let n = mesh.positions().len() as u32;
        let most =
            |most| SplitSequence::with_most_moves(Pulse::NONE, &surface.positions, &surface.faces, &merges, most);
        assert!(most(10_000).is_some() && most(100).is_none());
        for (kept, removed) in [(1, 1), (n, 0), (0, n), (merges[0].removed, 0), (0, merges[0].removed)] {
            let bad = [merges[0], RecordedMerge { kept, removed, ..merges[0] }];
            assert!(SplitSequence::new(Pulse::NONE, &surface.positions, &surface.faces, &bad).is_none());
        }
    }
}
