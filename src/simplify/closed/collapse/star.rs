//! One-rings of the ends of an edge.

use super::corners::{CornerStep, CornerTable, third};

/// One-ring of one end of an edge.
#[derive(Clone, Default)]
pub(super) struct EndRing {
    /// Neighbours in order: the other end, then the vertex opposite one face of the edge; last the one opposite the
    /// other face.
    pub ring: Vec<u32>,
    /// CornerTable of the end, one per neighbour.
    pub corners: Vec<u32>,
}

impl EndRing {
    /// Collects the one-ring of an end of the edge opposite `corner`.
    #[inline(always)]
    pub fn gather(&mut self, corners: &CornerTable, end: u32, corner: u32) {
        self.ring.clear();
        self.corners.clear();
        let at = corners.corner_at(corner, end);
        for step in corners.walk_around(CornerStep { at, from: third(corner, at) }) {
            self.ring.push(corners.vertex(step.from));
            self.corners.push(step.at);
        }
    }
}
