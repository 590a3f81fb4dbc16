//! Options of a comparison.

/// Number and seed of the samples for [`compare`](super::compare).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct CompareOptions {
    /// Samples on each surface, by default 50 thousand as in the paper.
    pub samples: usize,
    /// Seed of the original's samples; the simplified mesh's is one larger.
    pub seed: u64,
}

impl Default for CompareOptions {
    fn default() -> Self {
        Self { samples: 50_000, seed: 0 }
    }
}
