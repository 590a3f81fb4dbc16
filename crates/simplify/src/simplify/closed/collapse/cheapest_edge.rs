//! Price and edge packed into one number.

use super::corner_table::renumber_corner;

/// Cheapest edge of a vertex: price bits above the edge number, so that the least number is cheapest.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct CheapestEdge(pub u64);

impl CheapestEdge {
    pub const NONE: Self = Self(u64::MAX);

    pub fn renumber(self, faces: &[u32]) -> Self {
        if self == Self::NONE {
            self
        } else {
            Self(self.0 >> 32 << 32 | u64::from(renumber_corner(faces, self.edge())))
        }
    }

    #[inline(always)]
    pub fn new(price: f32, edge: u32) -> Self {
        if price < f32::INFINITY {
            Self(u64::from(price.max(0.0).to_bits()) << 32 | u64::from(edge))
        } else {
            Self::NONE
        }
    }

    #[inline(always)]
    pub fn price(self) -> f32 {
        if self == Self::NONE { f32::INFINITY } else { f32::from_bits((self.0 >> 32) as u32) }
    }

    #[inline(always)]
    pub fn edge(self) -> u32 {
        self.0 as u32
    }
}
