//! The network that an objective trains: its shapes, its first weights, its file.

use super::{Settings, TrainError};
use crate::autodiff::{Tensors, WeightsError};
use crate::learned_baselines::{LearnedBaseline, LearnedWeights};
use crate::linalg::Matrix;
use crate::model::{Architecture, Weights};
use std::sync::Arc;

/// A network with its sizes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Trained {
    /// The paper's.
    Paper(Architecture),
    /// That of another method, with the share of its widths.
    Learned(LearnedBaseline, f64),
}

impl Trained {
    /// The network that the settings train: that of a learned baseline where the objective has its name, else the paper's.
    pub fn of(settings: &Settings) -> Self {
        match LearnedBaseline::from_name(&settings.objective) {
            Some(baseline) => Self::Learned(baseline, settings.width_share),
            None => Self::Paper(settings.architecture()),
        }
    }

    /// The shapes of its tensors.
    pub fn shapes(&self) -> Tensors<[usize; 2]> {
        match self {
            Self::Paper(sizes) => sizes.shapes().named(),
            Self::Learned(baseline, width_share) => baseline.shapes(*width_share),
        }
    }

    /// The weights that a training begins with.
    pub fn random(&self, seed: u64) -> Tensors<Arc<Matrix>> {
        match self {
            Self::Paper(sizes) => Weights::random_of(*sizes, seed).tensors().named(),
            Self::Learned(baseline, width_share) => baseline.drawn(*width_share, seed),
        }
    }

    /// The file of its weights, which says by which objective they were learned.
    pub fn to_bytes(self, tensors: &Tensors<Arc<Matrix>>, objective: &str) -> Result<Vec<u8>, WeightsError> {
        match self {
            Self::Paper(sizes) => Ok(Weights::from_named(sizes, tensors)?.learned(objective).to_bytes()),
            Self::Learned(baseline, share) => Ok(LearnedWeights::from_tensors(baseline, share, tensors)?.to_bytes()),
        }
    }

    /// The settings with the sizes of the network in a file of weights, and its tensors.
    pub fn read(bytes: &[u8], settings: &Settings) -> Result<(Settings, Tensors<Arc<Matrix>>), TrainError> {
        let refused = |error: WeightsError| TrainError::Settings(error.to_string());
        match Self::of(settings) {
            Self::Paper(_) => {
                let weights = Weights::from_bytes(bytes).map_err(refused)?;
                Ok((settings.with_architecture(weights.architecture())?, weights.tensors().named()))
            }
            Self::Learned(baseline, _) => {
                let weights = LearnedWeights::from_bytes(bytes).map_err(refused)?;
                if weights.baseline() != baseline {
                    let [is, wanted] = [weights.baseline(), baseline].map(LearnedBaseline::name);
                    return Err(TrainError::Settings(format!("the weights learned {is}, not {wanted}: give others")));
                }
                Ok((settings.with_width_share(weights.width_share())?, weights.tensors().clone()))
            }
        }
    }

    /// The settings with the sizes that others have.
    pub fn with_sizes_of(settings: &Settings, other: &Settings) -> Result<Settings, TrainError> {
        settings.with_architecture(&other.architecture())?.with_width_share(other.width_share)
    }
}
