//! What each [`Optimize`] and [`Effort`] asks of the stages: the one place where they are told apart.

use crate::simplify::options::{Effort, Optimize};

/// What a result is to be near in, as the stages take it.
///
/// Twelve training meshes, four ratios, against the balanced one: `Mean` is 6 % nearer in the mean, the largest distance 11 % farther, in 1.3
/// of the time. What `Max` and `Normals` trade: `docs/measured/benchmark.md`. Prices times a power of the area serve none of them
/// (`docs/tried.md`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aim {
    /// How much of a score counts. From 0.6 to 1 results get 4 % farther in the mean, 2 % nearer at most, normal errors 9 % smaller; at 1.5
    /// `Max` is 10 % farther at most than the balanced one, and `Normals` has errors 5 % larger.
    pub strength: f32,
    /// Points of the fit per output vertex, at most. At 14, one point a face, the mean distance of eight meshes of 16,900
    /// to 50,000 vertices is 1.4 % farther.
    pub points_per_vertex: usize,
    /// Input faces per output vertex below which a point on each and one step of the fit are enough: the result is near
    /// the input then. There are four at a ratio of 0.5, where `Mean` is 8 % nearer for fitting there, too.
    pub few_faces: usize,
    /// Steps of the fit elsewhere. With one the mean distance of eight meshes of 16,900 to 50,000 vertices is 3 %
    /// farther; `Mean` gains 1.5 % by four and another 1 % by six. With none there are no flips either.
    pub steps: usize,
    /// Squared heights over a face, over their mean, up to about which all points count alike in the fit. `Max` is 3 %
    /// nearer at 3 than at 0.3.
    pub usual: f32,
    /// How often after the fit points that lie far from the faces draw them. `Max` gains 8 % by three times.
    pub draws: usize,
}

impl Default for Aim {
    /// Good in every figure.
    fn default() -> Self {
        Self { strength: 0.7, points_per_vertex: 28, few_faces: 8, steps: 2, usual: 0.3, draws: 0 }
    }
}

impl Aim {
    /// What serves this figure best, at this effort.
    ///
    /// Twelve training meshes of twelve families at ratios of 0.1 and 0.5: `Best` is 9 % nearer in the mean than `Standard`, in twice the
    /// time; where no scores are asked for, twice its steps and points bring another 1 %, in 1.6 times its time.
    pub fn of(optimize: Optimize, effort: Effort) -> Self {
        let standard = Self::standard(optimize);
        match effort {
            Effort::Fast => Self { steps: 0, draws: 0, ..standard },
            Effort::Standard => standard,
            Effort::Best => Self { points_per_vertex: 100, few_faces: 1, steps: 8, ..standard },
        }
    }

    fn standard(optimize: Optimize) -> Self {
        let balanced = Self::default();
        match optimize {
            Optimize::Balanced => balanced,
            // Where every vertex counts by its area, no place is nearer at another's cost.
            Optimize::Mean => Self { strength: 0.0, points_per_vertex: 50, few_faces: 2, steps: 4, ..balanced },
            Optimize::Max => Self { strength: 1.0, usual: 3.0, draws: 3, ..balanced },
            Optimize::Normals => Self { strength: 1.0, few_faces: 2, ..balanced },
        }
    }
}
