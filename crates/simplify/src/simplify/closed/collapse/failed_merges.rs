//! Why the merges of a vertex failed.

/// The failed merges of a vertex since it, or something next to it, changed.
#[derive(Clone, Copy)]
pub struct FailedMerges {
    /// Pass of the first failure.
    pub since: u32,
    /// Least deformation by which a merge exceeds a ceiling; infinite if all fail for other reasons.
    pub short_by: f32,
    pub was_turn_forbidden: bool,
    /// True once every edge has failed.
    pub are_all: bool,
}

impl FailedMerges {
    pub const NONE: Self = Self { since: 0, short_by: f32::INFINITY, was_turn_forbidden: false, are_all: false };

    /// Adds a failure by a turned face, or by a ceiling, exceeded by `short_by`.
    pub fn add(&mut self, short_by: Option<f32>) {
        self.was_turn_forbidden |= short_by.is_none();
        self.short_by = short_by.map_or(self.short_by, |short_by| self.short_by.min(short_by));
    }

    /// Counts a ceiling as higher by `risen_by`.
    pub fn raise_ceiling(&mut self, risen_by: f32) {
        if self.short_by < f32::INFINITY {
            self.short_by -= risen_by;
        }
    }
}
