//! Weights of learned methods.

use super::LearnedBaseline;
use neural_mesh::autodiff::{Tensors, WeightsError, architecture_text};
use neural_mesh::linalg::Matrix;
use neural_mesh::train::OwnNetwork;
use std::sync::{Arc, LazyLock};

// Shipped weights in the order of [`LearnedBaseline::ALL`].
const FILES: [&[u8]; 3] = [
    include_bytes!("../../weights/dse.safetensors"),
    include_bytes!("../../weights/potamias.safetensors"),
    include_bytes!("../../weights/pointtrinet.safetensors"),
];

static SHIPPED: LazyLock<[LearnedWeights; 3]> =
    LazyLock::new(|| FILES.map(|file| LearnedWeights::from_bytes(file).expect("shipped weights are valid")));

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
        let is_share = |share: &f64| *share > 0.0 && *share <= 1.0;
        let width_share = word("width_share").and_then(|share| share.parse().ok()).filter(is_share);
        let width_share = width_share.ok_or_else(|| bad("must state `width_share`, above 0 and at most 1"))?;
        let shapes = baseline.shapes(width_share);
        let tensors = Tensors::from_bytes(bytes, &shapes)?.check_shapes(&shapes)?;
        Ok(Self { baseline, width_share, tensors })
    }

    /// Writes a safetensors file.
    pub fn to_bytes(&self) -> Vec<u8> {
        self.tensors.to_bytes(&self.metadata())
    }

    fn metadata(&self) -> String {
        format!("width_share={} objective={}", self.width_share, self.baseline.name())
    }

    /// Returns the network as the start of a training.
    pub fn network(&self) -> OwnNetwork {
        OwnNetwork { tensors: self.tensors.clone(), about: self.metadata() }
    }

    /// Returns the shipped weights.
    pub fn load_shipped(baseline: LearnedBaseline) -> &'static Self {
        &SHIPPED[baseline as usize]
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
