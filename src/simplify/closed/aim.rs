//! What each [`Optimize`] asks of the stages: the one place where they are told apart.

use crate::simplify::options::Optimize;

/// What a result is to be near in, as the stages take it.
///
/// Nineteen training meshes, four ratios, against the balanced one: `Mean` is 9 % nearer in the mean, the largest distance 6 %
/// farther, in 1.5 of the time; `Max` 15 % nearer at most, 9 % farther in the mean, in 1.6 of the time; `Normals` has errors
/// of normals 3 % smaller, is 5 % farther in the mean. Prices times a power of the area serve none of them (`docs/tried.md`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aim {
    /// How much of a network's score counts. At 1 balanced results are 2 % farther in the mean, the normal error is 1 %
    /// smaller; at 2 the normal error grows again.
    pub strength: f32,
    /// Vertices over those asked for from which on every price is that of the present surface. At 1.5 balanced results are
    /// 1.5 % nearer in the mean, in 1.15 of the time; at 2 no nearer than at 1.5.
    pub last_stretch: f64,
    /// Points of the fit per output vertex, at most. At 14, one point a face, the mean distance of eight meshes of 16,900
    /// to 50,000 vertices is 1.4 % farther.
    pub points_per_vertex: usize,
    /// Input faces per output vertex below which a point on each and one step of the fit are enough: the result is near
    /// the input then. There are four at a ratio of 0.5, where `Mean` is 8 % nearer for fitting there, too.
    pub few_faces: usize,
    /// Steps of the fit elsewhere. With one the mean distance of eight meshes of 16,900 to 50,000 vertices is 3 %
    /// farther; `Mean` gains 1.5 % by four and another 1 % by six.
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
        Self { strength: 0.7, last_stretch: 1.1, points_per_vertex: 28, few_faces: 8, steps: 2, usual: 0.3, draws: 0 }
    }
}

impl Aim {
    /// What serves this figure best.
    pub fn of(optimize: Optimize) -> Self {
        let balanced = Self::default();
        match optimize {
            Optimize::Balanced => balanced,
            // Where every vertex counts by its area, no place is nearer at another's cost.
            Optimize::Mean => {
                Self { strength: 0.0, last_stretch: 1.5, points_per_vertex: 50, few_faces: 2, steps: 4, ..balanced }
            }
            Optimize::Max => Self { strength: 1.5, usual: 3.0, draws: 3, ..balanced },
            Optimize::Normals => Self { strength: 1.5, few_faces: 2, ..balanced },
        }
    }
}
