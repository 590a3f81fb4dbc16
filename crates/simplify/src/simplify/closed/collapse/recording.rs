//! Record of a collapse's merges, from which a progression makes meshes of any size.
//!
//! Merges whose surroundings are apart commute: the order of the record may change as long as merges that meet keep
//! their order. Sorting by the largest price that a merge depends on, its `key`, is such an order, and its first merges are
//! the cheapest.

use glam::Vec3;

use super::compaction::Compaction;

/// One merge, by vertices of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordedMerge {
    pub kept: u32,
    pub removed: u32,
    /// Position of the kept vertex after the merge, at unit size.
    pub position: Vec3,
    /// Largest price of this merge and of those before it that it depends on, at unit size.
    pub key: f32,
    /// True if the kept vertex moved to the place of the removed one.
    pub takes_removed_place: bool,
}

impl RecordedMerge {
    /// A merge without vertices and price.
    pub const UNPRICED: Self = Self { kept: 0, removed: 0, position: Vec3::ZERO, key: 0.0, takes_removed_place: false };
}

#[derive(Clone, Default)]
pub struct Recording {
    pub merges: Vec<RecordedMerge>,
    /// Key of the last merge of each node; 0 for none.
    pub(super) keys: Vec<f32>,
}

impl Recording {
    pub(super) fn compact(&mut self, vertices: &Compaction) {
        vertices.compact_rows(&mut self.keys, |key| key);
        self.keys.truncate(vertices.len());
    }
}
