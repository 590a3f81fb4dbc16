//! Corner table: the vertex at each corner, and the corner across the opposite edge.

use std::ops::Range;

use super::compaction::Compaction;
use crate::linalg::Rows;
use crate::mesh::half_edges::{HalfEdge, for_each_edge};

pub(super) const NONE: u32 = u32::MAX;

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
        let faces = Rows::new(n_vertices, faces.map(|[a, b, c]| (a.min(b).min(c), [a, b, c]))).into_items();
        let mut across = vec![NONE; 4 * faces.len()];
        let opposite = |side: HalfEdge| previous(side.half_edge / 3 * 4 + side.half_edge % 3);
        for_each_edge(n_vertices, &faces, |_, sides| {
            // A lone edge is left open; closed input has none.
            if let &[one, other] = sides {
                let [one, other] = [one, other].map(opposite);
                (across[one as usize], across[other as usize]) = (other, one);
            }
        });
        let mut vertices = vec![NONE; across.len()];
        vertices
            .as_chunks_mut::<4>()
            .0
            .iter_mut()
            .zip(&faces)
            .for_each(|(slots, face)| slots[..3].copy_from_slice(face));
        Self { vertices, across }
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
                let ends = |corner| {
                    let [a, b] = corners.edge(corner);
                    [a.min(b), a.max(b)]
                };
                assert_eq!((corners.corner_across(across), ends(across)), (c, ends(c)));
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
