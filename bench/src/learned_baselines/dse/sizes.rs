//! Sizes of patches and networks.

use crate::learned_baselines::scale_width;

/// Candidates per point; 120 in the paper.
pub const CANDIDATES: usize = 60;
/// Points of a patch besides its own; 30 in the paper.
pub const KEPT: usize = 24;

// Smallest width before the pooling, where layers cost little.
const LEAST_BEFORE_POOLING: usize = 32;

/// Layer widths of one network.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Widths {
    /// Pointwise layers before the pooling.
    pub pointwise: [usize; 5],
    /// Layers of the pooled features.
    pub pooled: [usize; 2],
    /// Layers of both stages after the pooling.
    pub joined: [usize; 2],
}

impl Widths {
    /// Scales the widths of the paper's program by a factor in (0, 1].
    ///
    /// ```
    /// use neural_mesh_bench::learned_baselines::dse::Widths;
    /// assert_eq!(Widths::from_share(1.0).pointwise, [64, 64, 128, 256, 1024]);
    /// assert_eq!(Widths::from_share(0.125).pointwise, [32, 32, 32, 32, 128]);
    /// ```
    pub fn from_share(share: f64) -> Self {
        let at_least = |full: usize| scale_width(full, share).max(LEAST_BEFORE_POOLING);
        let [a, b, c, d] = [64, 64, 128, 256].map(at_least);
        Self {
            pointwise: [a, b, c, d, scale_width(1024, share)],
            pooled: [1024, 1024].map(|full| scale_width(full, share)),
            joined: [1024, 528].map(|full| scale_width(full, share)),
        }
    }
}
