//! Weights of learned methods.

use super::LearnedBaseline;
use neural_mesh::autodiff::{Tensors, WeightsError, architecture_text};
use neural_mesh::linalg::Matrix;
use std::sync::{Arc, LazyLock};

const DSE_FILE: &[u8] = include_bytes!("../../weights/dse.safetensors");
const POTAMIAS_FILE: &[u8] = include_bytes!("../../weights/potamias.safetensors");

const POINTTRINET_FILE: &[u8] = include_bytes!("../../weights/pointtrinet.safetensors");

static DSE: LazyLock<LearnedWeights> = LazyLock::new(|| parse_shipped(DSE_FILE));
static POTAMIAS: LazyLock<LearnedWeights> = LazyLock::new(|| parse_shipped(POTAMIAS_FILE));

static POINTTRINET: LazyLock<LearnedWeights> = LazyLock::new(|| parse_shipped(POINTTRINET_FILE));

/// Finite weights with the shapes of a network.
#[derive(Clone, Debug, PartialEq)]
pub struct LearnedWeights {
    baseline: LearnedBaseline,
    width_share: f64,
    tensors: Tensors<Arc<Matrix>>,
}

impl LearnedWeights {
    /// Returns random weights; `width_share` is in (0, 1].
    pub fn random(baseline: LearnedBaseline, width_share: f64, seed: u64) -> Self {
        Self { baseline, width_share, tensors: baseline.initial_tensors(width_share, seed) }
    }

    /// Makes weights of tensors.
    ///
    /// # Errors
    /// [`WeightsError`] names the first wrong tensor.
    pub fn from_tensors(
        baseline: LearnedBaseline,
        width_share: f64,
        tensors: &Tensors<Arc<Matrix>>,
    ) -> Result<Self, WeightsError> {
        Ok(Self { baseline, width_share, tensors: tensors.check_shapes(&baseline.shapes(width_share))? })
    }

    /// Reads a safetensors file.
    ///
    /// # Errors
    /// [`WeightsError`] names the first fault.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, WeightsError> {
        let text = architecture_text(bytes)?;
        let word = |name: &str| text.split_whitespace().find_map(|word| word.strip_prefix(name)?.strip_prefix('='));
        let bad = |what: &str| WeightsError::BadArchitecture(what.into());
        let baseline = word("objective").and_then(LearnedBaseline::from_name);
        let baseline = baseline.ok_or_else(|| bad("states no `objective` of a learned baseline"))?;
        let width_share = word("width_share").and_then(|share| share.parse().ok()).filter(|share| is_share(*share));
        let width_share = width_share.ok_or_else(|| bad("must state `width_share`, above 0 and at most 1"))?;
        Self::from_tensors(baseline, width_share, &Tensors::from_bytes(bytes, &baseline.shapes(width_share))?)
    }

    /// Writes a safetensors file.
    pub fn to_bytes(&self) -> Vec<u8> {
        self.tensors.to_bytes(&self.metadata())
    }

    pub(super) fn metadata(&self) -> String {
        format!("width_share={} objective={}", self.width_share, self.baseline.name())
    }

    /// Returns the shipped weights.
    pub fn load_shipped(baseline: LearnedBaseline) -> &'static Self {
        match baseline {
            LearnedBaseline::Dse => &DSE,
            LearnedBaseline::Potamias => &POTAMIAS,
            LearnedBaseline::PointTriNet => &POINTTRINET,
        }
    }

    /// Returns the method.
    pub fn baseline(&self) -> LearnedBaseline {
        self.baseline
    }

    /// Returns all tensors.
    pub fn tensors(&self) -> &Tensors<Arc<Matrix>> {
        &self.tensors
    }
}

fn is_share(share: f64) -> bool {
    share > 0.0 && share <= 1.0
}

fn parse_shipped(file: &[u8]) -> LearnedWeights {
    LearnedWeights::from_bytes(file).expect("shipped weights are valid")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shipped_weights_are_of_their_method() {
        for baseline in LearnedBaseline::ALL {
            let weights = LearnedWeights::load_shipped(baseline);
            assert_eq!((weights.baseline(), LearnedBaseline::from_name(baseline.name())), (baseline, Some(baseline)));
            assert_eq!(LearnedWeights::from_bytes(&weights.to_bytes()).as_ref(), Ok(weights));
        }
    }

    #[test]
    fn the_first_wrong_setting_is_named() {
        let tensors = LearnedBaseline::Potamias.initial_tensors(0.25, 1);
        let refused = |text: &str| LearnedWeights::from_bytes(&tensors.to_bytes(text)).unwrap_err().to_string();
        assert!(refused("width_share=0.25 objective=paper").contains("`objective`"));
        for share in ["", "width_share=2", "width_share=nan", "width_share=0"] {
            assert!(refused(&format!("{share} objective=potamias")).contains("`width_share`"));
        }
        assert!(refused("width_share=0.5 objective=potamias").contains("has shape"));
        assert!(LearnedWeights::from_bytes(b"no weights").is_err());
    }
}
