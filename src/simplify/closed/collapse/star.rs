//! What surrounds an edge that is about to go.

use super::corners::{Corners, Step, third};

/// What surrounds an end of an edge.
#[derive(Clone, Default)]
pub(super) struct Star {
    /// Its neighbours in order, the other end first; then the vertex opposite to a face of the edge, last the one opposite to the other.
    pub ring: Vec<u32>,
    /// Its corners, one for each neighbour.
    pub corners: Vec<u32>,
}

impl Star {
    /// Gathers what surrounds an end of the edge opposite to a corner.
    #[inline(always)]
    pub fn gather(&mut self, corners: &Corners, end: u32, corner: u32) {
        self.ring.clear();
        self.corners.clear();
        let at = corners.beside(corner, end);
        for step in corners.around(Step { at, from: third(corner, at) }) {
            self.ring.push(corners.vertex(step.from));
            self.corners.push(step.at);
        }
    }
}
