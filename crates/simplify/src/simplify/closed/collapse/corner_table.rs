//! Corner table: the vertex at each corner, and the corner across the opposite edge.

use std::ops::Range;

use super::compaction::Compaction;

pub(super) const NONE: u32 = u32::MAX;
const SORTED_FROM: usize = 32;

#[derive(Clone, Default)]
pub(super) struct CornerTable {
    /// Vertex at each corner, n_faces x 4; [`NONE`] in every last slot and in removed faces.
    vertices: Vec<u32>,
    across: Vec<u32>,
}

#[inline(always)]
pub(super) fn next(corner: u32) -> u32 {
    // A face takes four slots, so that this needs no division.
    corner + 1 - 3 * ((corner & 2) >> 1)
}

#[inline(always)]
pub(super) fn previous(corner: u32) -> u32 {
    corner + 3 * u32::from(corner & 3 == 0) - 1
}

#[inline(always)]
pub(super) fn third_corner(first: u32, other: u32) -> u32 {
    // The three corner numbers within a face, 0 to 2, add up to 3.
    3 * (first & !3) + 3 - first - other
}

/// Face in a walk around a vertex: the vertex's corner, and the corner at the far end of the edge just crossed.
#[derive(Clone, Copy)]
pub(super) struct CornerStep {
    pub at: u32,
    pub from: u32,
}

impl CornerStep {
    #[inline(always)]
    pub fn opposite(self) -> u32 {
        third_corner(self.at, self.from)
    }
}

pub(super) struct VertexWalk<'a> {
    corners: &'a CornerTable,
    vertex: u32,
    end: u32,
    next: Option<CornerStep>,
}

impl Iterator for VertexWalk<'_> {
    type Item = CornerStep;

    #[inline(always)]
    fn next(&mut self) -> Option<CornerStep> {
        let step = self.next?;
        // The next face is across the edge opposite `from`.
        let opposite = self.corners.corner_across(step.from);
        let at = self.corners.corner_at(opposite, self.vertex);
        self.next = (at != self.end).then(|| CornerStep { at, from: third_corner(opposite, at) });
        Some(step)
    }
}

impl CornerTable {
    /// Builds the table of a closed complex; sorts the faces by their smallest vertices.
    pub fn new(n_vertices: usize, faces: impl Iterator<Item = [u32; 3]> + Clone) -> Self {
        let smallest = |[a, b, c]: [u32; 3]| a.min(b).min(c) as usize;
        // Counting sort of the faces by their smallest vertex.
        let mut places = vec![0u32; n_vertices + 1];
        faces.clone().for_each(|face| places[smallest(face) + 1] += 4);
        (0..n_vertices).for_each(|v| places[v + 1] += places[v]);
        let mut vertices = vec![NONE; places[n_vertices] as usize];
        for face in faces {
            let place = &mut places[smallest(face)];
            vertices[*place as usize..][..3].copy_from_slice(&face);
            *place += 4;
        }
        let mut table = Self { across: vec![NONE; vertices.len()], vertices };
        // Corners whose opposite edges have one smaller end form a linked list, stored in `across` for now.
        let mut firsts = vec![NONE; n_vertices];
        for c in 0..table.vertices.len() as u32 {
            if c & 3 != 3 {
                let first = &mut firsts[table.ends(c)[0] as usize];
                table.across[c as usize] = std::mem::replace(first, c);
            }
        }
        // Within each list, corners with one larger end are then matched.
        let mut edges = Vec::new();
        for mut c in firsts {
            edges.clear();
            while c != NONE {
                edges.push((table.ends(c)[1], c));
                c = table.corner_across(c);
            }
            match_edges(&mut edges, &mut table.across);
        }
        table
    }

    pub fn corners(&self) -> impl Iterator<Item = u32> {
        (0..self.vertices.len() as u32).filter(|&c| self.vertices[c as usize] != NONE)
    }

    pub fn n_faces(&self) -> usize {
        self.vertices.len() / 4
    }

    #[inline(always)]
    pub fn vertex(&self, corner: u32) -> u32 {
        self.vertices[corner as usize]
    }

    #[inline(always)]
    pub fn edge(&self, corner: u32) -> [u32; 2] {
        [self.vertex(next(corner)), self.vertex(previous(corner))]
    }

    fn ends(&self, corner: u32) -> [u32; 2] {
        let [a, b] = self.edge(corner);
        [a.min(b), a.max(b)]
    }

    #[inline(always)]
    pub fn corner_across(&self, corner: u32) -> u32 {
        self.across[corner as usize]
    }

    /// Returns the remaining faces in a range, each as first corner number, vertices, and corners across its edges.
    #[inline(always)]
    pub fn faces_in(&self, numbers: Range<usize>) -> impl Iterator<Item = (u32, [u32; 3], [u32; 3])> {
        let firsts = (4 * numbers.start as u32..).step_by(4);
        let vertices = self.vertices.as_chunks::<4>().0[numbers.clone()].iter();
        let across = self.across.as_chunks::<4>().0[numbers].iter();
        let faces = firsts.zip(vertices.zip(across)).filter(|(_, (vertices, _))| vertices[0] != NONE);
        faces.map(|(first, (&[a, b, c, _], &[d, e, f, _]))| (first, [a, b, c], [d, e, f]))
    }

    /// Returns the number of the edge opposite `corner`: the smaller of the two corners that face this edge.
    #[inline(always)]
    pub fn number_of_edge(&self, corner: u32) -> u32 {
        corner.min(self.corner_across(corner))
    }

    #[inline(always)]
    pub fn corner_at(&self, corner: u32, vertex: u32) -> u32 {
        let next = next(corner);
        if self.vertex(next) == vertex { next } else { previous(corner) }
    }

    #[inline(always)]
    pub fn walk_around(&self, first: CornerStep) -> VertexWalk<'_> {
        VertexWalk { corners: self, vertex: self.vertex(first.at), end: first.at, next: Some(first) }
    }

    #[inline(always)]
    pub fn set_vertex(&mut self, corner: u32, vertex: u32) {
        self.vertices[corner as usize] = vertex;
    }

    /// Removes the face of `corner`, whose opposite edge collapsed; joins the faces across its other edges.
    ///
    /// Returns corners at the vertex of `corner` and at the merged vertex.
    #[inline(always)]
    pub fn remove_face(&mut self, corner: u32) -> [u32; 2] {
        // The two neighbours of the removed face become neighbours of each other.
        let apex = self.vertex(corner);
        let [first, other] = [next(corner), previous(corner)].map(|c| self.corner_across(c));
        (self.across[first as usize], self.across[other as usize]) = (other, first);
        let face = (corner & !3) as usize;
        self.vertices[face..face + 3].fill(NONE);
        let at_apex = self.corner_at(first, apex);
        [at_apex, third_corner(first, at_apex)]
    }

    pub fn retain(&mut self, mut stays: impl FnMut([u32; 3]) -> bool) {
        let faces = self.vertices.chunks_exact_mut(4).filter(|slots| slots[0] != NONE);
        faces.for_each(|slots| {
            if !stays([slots[0], slots[1], slots[2]]) {
                slots[..3].fill(NONE);
            }
        });
    }

    /// Compacts the faces and renumbers their vertices; returns the new face numbers.
    pub fn compact(&mut self, numbers: &[u32]) -> Compaction {
        let vertices = self.vertices.as_chunks_mut::<4>().0;
        let faces = Compaction::new(vertices.len(), |face| vertices[face][0] != NONE);
        // Vertices get their new numbers, corners those of their moved faces.
        let renumbered = |[a, b, c, _]: [u32; 4]| {
            let [a, b, c] = [a, b, c].map(|v| numbers[v as usize]);
            [a, b, c, NONE]
        };
        faces.compact_rows(vertices, renumbered);
        let moved = |[a, b, c, _]: [u32; 4]| {
            let [a, b, c] = [a, b, c].map(|corner| renumber_corner(faces.numbers(), corner));
            [a, b, c, NONE]
        };
        faces.compact_rows(self.across.as_chunks_mut::<4>().0, moved);
        self.vertices.truncate(4 * faces.len());
        self.across.truncate(4 * faces.len());
        faces
    }

    pub fn faces(&self) -> impl Iterator<Item = [u32; 3]> {
        self.vertices.chunks_exact(4).filter(|slots| slots[0] != NONE).map(|slots| [slots[0], slots[1], slots[2]])
    }
}

#[inline(always)]
pub(super) fn renumber_corner(faces: &[u32], corner: u32) -> u32 {
    4 * faces[corner as usize / 4] + (corner & 3)
}

/// Joins the two corners opposite each edge of a vertex; `edges` lists other ends with these corners.
fn match_edges(edges: &mut [(u32, u32)], across: &mut [u32]) {
    // Sorting makes partners adjacent, which keeps the search below linear at vertices of high valence.
    if edges.len() > SORTED_FROM {
        edges.sort_unstable();
    }
    let mut rest = edges;
    while let [(end, corner), others @ ..] = rest {
        // A lone edge is left open; closed input has none.
        if let Some(at) = others.iter().position(|(other, _)| other == end) {
            let other = others[at].1;
            (across[*corner as usize], across[other as usize]) = (other, *corner);
            others.swap(0, at);
            rest = &mut others[1..];
        } else {
            across[*corner as usize] = NONE;
            rest = others;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{OneRings, TriMesh, shapes};

    fn close_mesh(mesh: &TriMesh) -> (OneRings, CornerTable) {
        let rings = OneRings::new(mesh.positions().len(), mesh.faces()).unwrap();
        let faces = mesh.faces().iter().copied().chain(rings.ghost_faces());
        let corners = CornerTable::new(rings.n_vertices() + rings.n_ghosts(), faces);
        (rings, corners)
    }

    #[test]
    fn walks_meet_the_neighbours_in_their_order_and_edges_have_one_number() {
        let fan: Vec<[u32; 3]> = (1..100).map(|i| [0, i, i + 1]).collect();
        let fan = TriMesh::new((0..101).map(|i| [i as f32, (i * i) as f32, 0.0]).collect(), fan).unwrap();
        for mesh in [shapes::icosphere(2), shapes::open_cylinder(7, 4), shapes::klein_bottle(8, 6), fan] {
            let (rings, corners) = close_mesh(&mesh);
            for c in corners.corners() {
                let across = corners.corner_across(c);
                assert_eq!((corners.corner_across(across), corners.ends(across)), (c, corners.ends(c)));
                assert_eq!(corners.number_of_edge(c), corners.number_of_edge(across));
                let v = corners.vertex(c);
                if v as usize >= rings.n_vertices() {
                    continue;
                }
                let mut walked = Vec::new();
                for step in corners.walk_around(CornerStep { at: c, from: next(c) }) {
                    assert_eq!(corners.vertex(step.at), v);
                    walked.push(corners.vertex(step.from));
                }
                let ring = rings.ring(v);
                let start = ring.iter().position(|&w| w == walked[0]).unwrap();
                let turned = |back: bool| {
                    let n = ring.len();
                    (0..n).map(move |i| ring[if back { start + n - i } else { start + i } % n])
                };
                assert!(turned(false).eq(walked.iter().copied()) || turned(true).eq(walked.iter().copied()));
            }
        }
    }

    #[test]
    fn remaining_faces_are_compacted() {
        // A bipyramid over a square, whose edge from 1 to 2 collapses.
        let faces = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1], [5, 2, 1], [5, 3, 2], [5, 4, 3], [5, 1, 4]];
        let mut corners = CornerTable::new(6, faces.into_iter());
        for c in corners.corners().filter(|&c| corners.vertex(c) == 2).collect::<Vec<u32>>() {
            corners.set_vertex(c, 1);
        }
        for (corner, apex) in [(0, 0), (16, 5)] {
            assert_eq!(
                (corners.vertex(corner), corners.remove_face(corner).map(|c| corners.vertex(c))),
                (apex, [apex, 1])
            );
        }
        corners.compact(&[0, 1, 2, 2, 3, 4]);
        let left: Vec<[u32; 3]> = corners.faces().collect();
        assert_eq!(left, [[0, 1, 2], [0, 2, 3], [0, 3, 1], [4, 1, 3], [4, 2, 1], [4, 3, 2]]);
        let again = CornerTable::new(5, left.into_iter());
        assert!(again.corners().all(|c| again.corner_across(c) == corners.corner_across(c)));
    }
}
