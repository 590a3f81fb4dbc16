//! The two ways of drawing samples (Sec. 3.1).

use super::{gumbel_top_k, scattered_samples};
use crate::linalg::Csr;

/// Way of drawing samples by their scores.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize), serde(rename_all = "lowercase"))]
pub enum Draw {
    /// Apart from each other: nearer to the original.
    #[default]
    Scattered,
    /// Each by itself, as the paper prints it.
    Multinomial,
}

impl Draw {
    /// Draws `k` different vertices by [`scattered_samples`] or [`gumbel_top_k`], whose arguments these are.
    pub fn draw_samples(self, points: &[[f32; 3]], rings: &Csr, scores: &[f32], k: usize, seed: u64) -> Vec<u32> {
        match self {
            Self::Scattered => scattered_samples(points, rings, scores, k, seed),
            Self::Multinomial => gumbel_top_k(scores, k, seed),
        }
    }
}
