//! One-rings of the ends of an edge.

use super::corner_table::{CornerStep, third_corner};
use super::stretch::{Stretch, Within};

#[derive(Clone, Default)]
pub(super) struct EndRing {
    /// Neighbours of one end, in order: the other end first, the two opposite vertices second and last.
    pub ring: Vec<u32>,
    pub corners: Vec<u32>,
}

impl EndRing {
    #[inline(always)]
    pub fn gather(&mut self, stretch: &Stretch, end: u32, corner: u32) -> Within<()> {
        self.ring.clear();
        self.corners.clear();
        let at = stretch.corners.corner_at(corner, end);
        stretch.walk(end, CornerStep { at, from: third_corner(corner, at) }, |step| {
            self.ring.push(stretch.corners.vertex(step.from));
            self.corners.push(step.at);
        })
    }
}
