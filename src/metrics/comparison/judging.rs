//! What a comparison measures, and from how many samples.

/// What is measured, and from how many samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Judging {
    /// Samples on each surface; the paper's 50 thousand by default.
    pub samples: usize,
    /// Decides where the samples lie; those of the simplified mesh are drawn with the next one.
    pub seed: u64,
}

impl Default for Judging {
    fn default() -> Self {
        Self { samples: 50_000, seed: 0 }
    }
}
