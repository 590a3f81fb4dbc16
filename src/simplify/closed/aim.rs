//! Settings of the stages for each [`Optimize`] and [`Effort`].

use crate::simplify::options::{Effort, Optimize};

/// Trade-offs of the stages. Twelve meshes: with `Mean` the mean distance is 6 % smaller, the largest 11 % larger, in
/// 1.3 of the time. Others: `docs/measured/benchmark.md`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aim {
    /// Factor on the scores. From 0.6 to 1 the mean distance grows by 4 %, normal errors fall by 9 %.
    pub strength: f32,
    /// Largest number of sample points per output vertex. At 14 the mean distance is 1.4 % larger.
    pub points_per_vertex: usize,
    /// Input faces per output vertex below which one point a face and one step suffice. `Mean` gains 8 % by more at a
    /// ratio of 0.5.
    pub few_faces: usize,
    /// Steps of the fit. One gives a 3 % larger mean distance; at 0 there are no flips either.
    pub steps: usize,
    /// Squared height over its face's mean up to which points have full weight. `Max` gains 3 % at 3.
    pub full_weight: f32,
    /// Rounds in which far points attract their faces. `Max` gains 8 % by three.
    pub far_rounds: usize,
}

impl Default for Aim {
    fn default() -> Self {
        Self { strength: 0.7, points_per_vertex: 28, few_faces: 8, steps: 2, full_weight: 0.3, far_rounds: 0 }
    }
}

impl Aim {
    /// Returns the settings for an error measure and an effort. `Best` has a 9 % smaller mean distance than `Standard`
    /// in twice the time.
    pub fn new(optimize: Optimize, effort: Effort) -> Self {
        let standard = Self::standard(optimize);
        match effort {
            Effort::Fast => Self { steps: 0, far_rounds: 0, ..standard },
            Effort::Standard => standard,
            Effort::Best => Self { points_per_vertex: 100, few_faces: 1, steps: 8, ..standard },
        }
    }

    fn standard(optimize: Optimize) -> Self {
        let balanced = Self::default();
        match optimize {
            Optimize::Balanced => balanced,
            // Without scores no place gains at another's cost.
            Optimize::Mean => Self { strength: 0.0, points_per_vertex: 50, few_faces: 2, steps: 4, ..balanced },
            Optimize::Max => Self { strength: 1.0, full_weight: 3.0, far_rounds: 3, ..balanced },
            Optimize::Normals => Self { strength: 1.0, few_faces: 2, ..balanced },
        }
    }
}
