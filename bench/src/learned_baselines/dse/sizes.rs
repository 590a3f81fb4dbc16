//! How large patches and networks are.

use crate::learned_baselines::share_of;

/// Nearest other points of a point among which the classifier chooses; the paper has 120.
pub const CANDIDATES: usize = 60;
/// Those of them that make the patch; the paper has 30.
pub const KEPT: usize = 24;

/// Layers before the pooling are not narrower than this, whatever the share of the widths: they cost little.
const LEAST_BEFORE_POOLING: usize = 32;

/// Widths of the layers of one of the two networks. Both have the same but for what comes out.
///
/// The full ones are those of the paper's program: 64-64-128-256-1024 before the pooling, 1024-1024 after it, 1024-528 over
/// each point. What trains on two cores in hours has an eighth of them, with half of the paper's neighbours.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Widths {
    /// Of the layers over each point before the pooling.
    pub pointwise: [usize; 5],
    /// Of the layers over what was pooled.
    pub pooled: [usize; 2],
    /// Of the layers over each point with what was pooled, in both stages.
    pub joined: [usize; 2],
}

impl Widths {
    /// A share of the full widths, above 0 and at most 1.
    ///
    /// ```
    /// use neural_mesh_bench::learned_baselines::dse::Widths;
    /// assert_eq!(Widths::of_share(1.0).pointwise, [64, 64, 128, 256, 1024]);
    /// assert_eq!(Widths::of_share(0.125).pointwise, [32, 32, 32, 32, 128]);
    /// ```
    pub fn of_share(share: f64) -> Self {
        let at_least = |full: usize| share_of(full, share).max(LEAST_BEFORE_POOLING);
        let [a, b, c, d] = [64, 64, 128, 256].map(at_least);
        Self {
            pointwise: [a, b, c, d, share_of(1024, share)],
            pooled: [1024, 1024].map(|full| share_of(full, share)),
            joined: [1024, 528].map(|full| share_of(full, share)),
        }
    }
}
