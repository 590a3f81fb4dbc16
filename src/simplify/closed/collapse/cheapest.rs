//! The cheapest edge of a vertex, as one number.

use super::corners::moved;

/// The cheapest edge of a vertex: the bits of its price above its number, so that the least number is the cheapest edge. Prices are not
/// negative.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Cheapest(pub u64);

impl Cheapest {
    /// No edge.
    pub const NONE: Self = Self(u64::MAX);

    /// The same edge where the faces have these new numbers.
    pub fn moved(self, faces: &[u32]) -> Self {
        if self == Self::NONE { self } else { Self(self.0 >> 32 << 32 | u64::from(moved(faces, self.edge()))) }
    }

    /// The edge of this number; none where the price is not finite.
    #[inline(always)]
    pub fn new(price: f32, edge: u32) -> Self {
        if price < f32::INFINITY {
            Self(u64::from(price.max(0.0).to_bits()) << 32 | u64::from(edge))
        } else {
            Self::NONE
        }
    }

    /// The price of the edge; not finite where there is none.
    #[inline(always)]
    pub fn price(self) -> f32 {
        if self == Self::NONE { f32::INFINITY } else { f32::from_bits((self.0 >> 32) as u32) }
    }

    /// The number of the edge: a corner opposite to it.
    #[inline(always)]
    pub fn edge(self) -> u32 {
        self.0 as u32
    }
}
