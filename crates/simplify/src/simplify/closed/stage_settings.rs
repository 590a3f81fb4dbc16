//! Settings of the stages for each error measure and effort.

use crate::simplify::options::{Effort, Optimize};

// On twelve meshes `Optimize::Mean` has a mean distance 6 % smaller and a largest distance 11 % larger than
// `Optimize::Balanced`, in 1.3 of the time. Figures of the others: `docs/measured/benchmark.md`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StageSettings {
    // Factor on the scores: from 0.6 to 1 the mean distance grows by 4 %, normal errors fall by 9 %.
    pub strength: f32,
    // Most sample points per output vertex: at 14 the mean distance is 1.4 % larger.
    pub points_per_vertex: usize,
    /// Input faces per output vertex below which one point a face and one step suffice.
    // At a ratio of 0.5, more points and steps reduce the mean distance of `Optimize::Mean` by 8 %.
    pub few_faces: usize,
    /// Steps of the fit; at 0 there are no flips either.
    // One step gives a 3 % larger mean distance.
    pub steps: usize,
    /// Mean squared height of a face, over that of all, up to which its points have nearly full weight.
    // At 3 instead of 0.3, the largest distance of `Optimize::Max` is 3 % smaller.
    pub full_weight: f32,
    /// Rounds in which far points attract their faces.
    // Three rounds reduce the largest distance of `Optimize::Max` by 8 %.
    pub far_rounds: usize,
    /// Distance at unit size from which a vertex can be a spike.
    // A pixel in a picture of a thousand is 1e-3. At 1e-3 instead of 3e-3, a plate with pipes is 1.7 times as far.
    pub least_spike: f32,
    /// True if surfaces count by what a viewer sees of them.
    pub by_looks: bool,
}

impl Default for StageSettings {
    fn default() -> Self {
        Self {
            strength: 0.7,
            points_per_vertex: 28,
            few_faces: 8,
            steps: 2,
            full_weight: 0.3,
            far_rounds: 0,
            least_spike: 3e-3,
            by_looks: false,
        }
    }
}

impl StageSettings {
    pub fn new(optimize: Optimize, effort: Effort) -> Self {
        let standard = Self::standard(optimize);
        match effort {
            Effort::Fast => Self { steps: 0, far_rounds: 0, ..standard },
            Effort::Standard => standard,
            // Mean distances are 3 to 8 % smaller than in `Standard`; with eight steps 1 to 2 % more, in 1.6 times the time.
            Effort::Best => Self { points_per_vertex: 100, few_faces: 1, steps: 4, ..standard },
        }
    }

    fn standard(optimize: Optimize) -> Self {
        let balanced = Self::default();
        match optimize {
            Optimize::Balanced => balanced,
            // Without scores no region gains at the cost of another.
            Optimize::Mean => Self { strength: 0.0, points_per_vertex: 50, few_faces: 2, steps: 4, ..balanced },
            Optimize::Max => Self { strength: 1.0, full_weight: 3.0, far_rounds: 3, ..balanced },
            // At 0 FLIP errors are 2 % larger on textured meshes, at 0.35 1 %.
            Optimize::Looks => Self { strength: 0.2, least_spike: 1e-3, by_looks: true, ..balanced },
            Optimize::Normals => Self { strength: 1.0, few_faces: 2, ..balanced },
        }
    }
}
