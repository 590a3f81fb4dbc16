//! The mesh of a pass: every vertex with its neighbours in cyclic order, all in one array. There are no faces or corners.
//!
//! Two neighbours in a row span a face with the vertex. A vertex inside has a closed ring; a boundary vertex has an open
//! one, from the one boundary edge to the other.

use std::ops::Range;

/// No vertex.
pub(crate) const NONE: u32 = u32::MAX;

/// Readable entries behind the last ring, since kernels load eight at a time.
pub(crate) const PADDING: usize = 16;

/// Bits of [`Rings::states`].
pub(crate) mod state {
    /// The ring is open.
    pub const BOUNDARY: u8 = 1;
    /// The vertex keeps its position.
    pub const LOCKED: u8 = 2;
    /// Others were merged into the vertex in this pass.
    pub const MERGED: u8 = 4;
    /// The vertex was merged into another in this pass, or has no face.
    pub const GONE: u8 = 8;
    /// A merge with `refused` was refused since the ring last changed.
    pub const REFUSED: u8 = 16;
    /// So was a second one: the vertex asks for no merge.
    pub const RESTS: u8 = 32;
    /// The vertex has two edges of a line, and is merged only along it.
    pub const LINE: u8 = 64;
    /// A line ends at the vertex, which has one wedge: it is merged along the line, or into vertices that are not held.
    pub const END: u8 = 128;
    /// Lines branch at the vertex or meet a boundary: it stays.
    pub const FORK: u8 = LINE | END;
    /// States that limit merges.
    pub const HELD: u8 = BOUNDARY | LOCKED | LINE | END;
}

/// A position, and within a pass the vertex that it belongs to: itself, or the one it was merged into.
#[repr(C, align(16))]
#[derive(Clone, Copy, Default, Debug, PartialEq)]
pub(crate) struct Vertex {
    pub position: [f32; 3],
    pub survivor: u32,
}

impl Vertex {
    pub(crate) fn new(position: [f32; 3], survivor: u32) -> Vertex {
        Vertex { position, survivor }
    }
}

/// A mesh by rings; all arrays have one entry per vertex unless said.
#[derive(Clone, Default)]
pub(crate) struct Rings {
    pub vertices: Vec<Vertex>,
    /// Where each ring starts, and where the last ends: one more than vertices.
    pub starts: Vec<u32>,
    /// All rings, then [`PADDING`].
    pub neighbors: Vec<u32>,
    /// Lengths of the rings after the merges of this pass.
    pub degrees: Vec<u32>,
    pub states: Vec<u8>,
    /// The neighbour of the last refused merge, if the state says so.
    pub refused: Vec<u32>,
    /// Largest distance between the vertex' surface and the input's, as the guard has followed it.
    pub errors: Vec<f32>,
    /// The neighbours along the line of each vertex that is on one, of which an end has one; empty without lines.
    pub lines: Vec<[u32; 2]>,
    pub n_faces: usize,
}

/// The part of [`Rings`] that does not change within a pass.
#[derive(Clone, Copy)]
pub(crate) struct RingsView<'a> {
    pub starts: &'a [u32],
    pub neighbors: &'a [u32],
    pub lines: &'a [[u32; 2]],
}

impl RingsView<'_> {
    #[inline(always)]
    pub(crate) fn ring(&self, vertex: u32) -> &[u32] {
        &self.neighbors[self.starts[vertex as usize] as usize..self.starts[vertex as usize + 1] as usize]
    }

    /// Returns whether a vertex may be merged into its neighbour, both with their states: along what it lies on.
    pub(crate) fn may_go(&self, (goes, state): (u32, u8), (stays, other): (u32, u8)) -> bool {
        let is_along = || self.lines[goes as usize].contains(&stays);
        match state & state::FORK {
            _ if state & state::LOCKED != 0 => false,
            state::FORK => false,
            _ if state & state::BOUNDARY != 0 => {
                let ring = self.ring(goes);
                other & state::BOUNDARY != 0 && (ring.first() == Some(&stays) || ring.last() == Some(&stays))
            }
            state::LINE => is_along(),
            state::END => other & state::HELD == 0 || is_along(),
            _ => true,
        }
    }
}

impl Rings {
    #[inline(always)]
    pub(crate) fn range(&self, vertex: usize) -> Range<usize> {
        self.starts[vertex] as usize..self.starts[vertex + 1] as usize
    }

    #[inline(always)]
    pub(crate) fn ring(&self, vertex: usize) -> &[u32] {
        &self.neighbors[self.range(vertex)]
    }

    pub(crate) fn view(&self) -> RingsView<'_> {
        RingsView { starts: &self.starts, neighbors: &self.neighbors, lines: &self.lines }
    }

    pub(crate) fn is_boundary(&self, vertex: usize) -> bool {
        self.states[vertex] & state::BOUNDARY != 0
    }

    /// Returns the faces, each once, from its lowest vertex.
    pub(crate) fn to_faces(&self) -> Vec<[u32; 3]> {
        let mut faces = Vec::with_capacity(self.n_faces);
        for u in 0..self.vertices.len() {
            let ring = self.ring(u);
            let Some(&last) = ring.last() else { continue };
            // No face lies before the first neighbour of an open ring.
            let mut previous = if self.is_boundary(u) { 0 } else { last };
            for &next in ring {
                if (u as u32) < previous && (u as u32) < next {
                    faces.push([u as u32, previous, next]);
                }
                previous = next;
            }
        }
        faces
    }

    /// Checks that rings agree with each other: each face is in three rings, in one direction.
    #[cfg(test)]
    pub(crate) fn sanity_check(&self) {
        assert_eq!(self.starts.len(), self.vertices.len() + 1);
        assert_eq!(self.neighbors.len(), self.starts[self.vertices.len()] as usize + PADDING);
        let mut corners = std::collections::HashSet::new();
        for u in 0..self.vertices.len() {
            let ring = self.ring(u);
            assert_eq!(ring.len(), self.degrees[u] as usize);
            assert!(ring.iter().all(|&v| v as usize != u && (v as usize) < self.vertices.len()));
            let n_faces = if self.is_boundary(u) { ring.len().saturating_sub(1) } else { ring.len() };
            for i in 0..n_faces {
                assert!(corners.insert((u as u32, ring[i], ring[(i + 1) % ring.len()])), "a face is twice at {u}");
            }
        }
        assert!(corners.iter().all(|&(u, v, w)| corners.contains(&(v, w, u))));
        assert_eq!(corners.len(), 3 * self.n_faces);
        assert_eq!(self.to_faces().len(), self.n_faces);
    }
}
