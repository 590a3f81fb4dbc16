//! One-rings of the ends of an edge.

use super::corner_table::{CornerStep, CornerTable, third_corner};

#[derive(Clone, Default)]
pub(super) struct EndRing {
    /// Neighbours of one end, in order: the other end first, the two opposite vertices second and last.
    pub ring: Vec<u32>,
    pub corners: Vec<u32>,
}

impl EndRing {
    #[inline(always)]
    pub fn gather(&mut self, corners: &CornerTable, end: u32, corner: u32) {
        self.ring.clear();
        self.corners.clear();
        let at = corners.corner_at(corner, end);
        for step in corners.walk_around(CornerStep { at, from: third_corner(corner, at) }) {
            self.ring.push(corners.vertex(step.from));
            self.corners.push(step.at);
        }
    }
}
