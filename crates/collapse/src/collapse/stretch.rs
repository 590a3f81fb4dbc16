//! What merges read and write: the rings of a pass, and the part of the vertices that one piece of work may change.

use crate::collapse::price::PriceTerms;
use crate::collapse::rings::{RingsView, Vertex, state};

/// What all merges of a pass read.
#[derive(Clone, Copy)]
pub(crate) struct PassView<'a> {
    pub rings: RingsView<'a>,
    pub terms: PriceTerms<'a>,
    /// Bits of the price up to which vertices are visited.
    pub threshold: u32,
    /// Largest usual price of a merge, at most that of the threshold.
    pub price: f32,
    /// Largest error of a vertex whose star is not flat.
    pub guard: f32,
    /// Largest error of any vertex.
    pub max_error: f32,
}

/// The vertices from `first` on, which one thread merges. Inside, they are counted from there.
pub(crate) struct VertexStretch<'a> {
    pub first: u32,
    pub vertices: &'a mut [Vertex],
    pub degrees: &'a mut [u32],
    pub states: &'a mut [u8],
    /// Price and other end of the best edge; after a merge, the vertex that was merged.
    pub best: &'a mut [u64],
    pub refused: &'a mut [u32],
    pub errors: &'a mut [f32],
}

impl VertexStretch<'_> {
    /// Returns the survivor of a vertex, both counted within the stretch; none if one is outside.
    #[inline(always)]
    pub(crate) fn survivor(&self, vertex: u32) -> Option<u32> {
        let survivor = self.vertices.get(vertex.wrapping_sub(self.first) as usize)?.survivor.wrapping_sub(self.first);
        ((survivor as usize) < self.vertices.len()).then_some(survivor)
    }

    /// Returns whether a vertex would have too few neighbours if it lost one.
    #[inline(always)]
    pub(crate) fn has_least_degree(&self, vertex: u32) -> bool {
        let least = if self.states[vertex as usize] & state::BOUNDARY != 0 { 2 } else { 3 };
        self.degrees[vertex as usize] <= least
    }

    /// Moves `u` to `position` and merges `v` into it; both counted within the stretch.
    #[inline(always)]
    pub(crate) fn write_merge(&mut self, u: u32, v: u32, position: [f32; 3], degree: usize, error: f32) {
        let survivor = Vertex::new(position, u + self.first);
        let (u, other) = (u as usize, u64::from(v + self.first));
        self.vertices[u] = survivor;
        self.vertices[v as usize] = survivor;
        self.states[u] |= state::MERGED;
        self.states[v as usize] |= state::GONE;
        self.best[u] = other;
        self.degrees[u] = degree as u32;
        self.errors[u] = error;
    }
}

/// Why a merge did not take place.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Refusal {
    /// A vertex around the edge is in another stretch.
    Outside,
    /// The result would not be manifold, or both ends are held.
    Topology,
    /// A face would turn.
    Turn,
    /// The result would be too far from what it replaces.
    Guard,
}
