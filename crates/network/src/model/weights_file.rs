//! Weights in safetensors files.

use super::weights::OBJECTIVE;
use super::{Architecture, Weights, WeightsError};
use crate::autodiff::{Tensors, architecture_text};

impl Weights {
    /// Reads a safetensors file, ignoring other tensors.
    ///
    /// # Errors
    /// [`WeightsError`] names the first fault of sizes, shapes or numbers.
    ///
    /// ```
    /// # use neural_mesh_network as neural_mesh;
    /// use neural_mesh::model::Weights;
    /// let weights = Weights::random(7);
    /// assert_eq!(Weights::from_bytes(&weights.to_bytes()).unwrap(), weights);
    /// assert!(Weights::from_bytes(b"no weights").is_err());
    /// ```
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, WeightsError> {
        let text = architecture_text(bytes)?;
        let architecture = Architecture::from_text(&text).map_err(WeightsError::BadArchitecture)?;
        let tensors = Tensors::from_bytes(bytes, &architecture.shapes().named_tensors())?;
        Ok(Self::from_named(architecture, &tensors)?.with_objective_of(&text))
    }

    /// Writes a safetensors file with the sizes in the metadata; equal weights give equal bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        self.tensors().named_tensors().to_bytes(&text(self))
    }
}

/// Returns the sizes as `name=size` words, then the objective.
fn text(weights: &Weights) -> String {
    let sizes = weights.architecture().sizes().map(|(name, size)| format!("{name}={size}")).join(" ");
    weights.objective().map_or(sizes.clone(), |objective| format!("{sizes} {OBJECTIVE}{objective}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::Matrix;
    use safetensors::tensor::{Dtype, TensorView, serialize};
    use std::collections::HashMap;
    use std::sync::Arc;

    fn small() -> Weights {
        let sizes = Architecture {
            point_sampler_inputs: 6,
            point_sampler_layers: 2,
            point_sampler_width: 4,
            point_sampler_hidden: 0,
            edge_predictor_width: 5,
            attention_width: 3,
            edge_knn: 4,
            face_classifier_layers: 1,
            face_classifier_width: 6,
            face_candidates: 0,
            face_knn: 3,
        };
        Weights::random_of(sizes, 1)
    }

    fn bytes_with(weights: &Weights, change: impl Fn(&str, &Matrix) -> Matrix) -> Vec<u8> {
        weights.tensors().named_tensors().map(|name, matrix| Arc::new(change(name, matrix))).to_bytes(&text(weights))
    }

    #[test]
    fn bytes_round_trip_and_do_not_vary() {
        let weights = small();
        assert_eq!(weights.to_bytes(), weights.clone().to_bytes());
        assert_eq!(Weights::from_bytes(&weights.to_bytes()), Ok(weights));
        assert_ne!(Weights::random(1), Weights::random(2));
    }

    #[test]
    fn wrong_tensors_are_named() {
        let score = "point_sampler.score.weights";
        let change = |to: fn(&Matrix) -> Matrix| {
            let bytes = bytes_with(&small(), |name, m| if name == score { to(m) } else { m.clone() });
            Weights::from_bytes(&bytes).unwrap_err()
        };
        let expected = [4, 1];
        let wrong_shape = WeightsError::WrongShape { name: score.into(), expected, found: vec![1, 4] };
        assert_eq!(change(Matrix::transpose), wrong_shape);
        assert_eq!(change(|_| Matrix::new(4, 1, vec![0.0, f32::NAN, 0.0, 0.0])), WeightsError::NotFinite(score.into()));
    }

    #[test]
    fn missing_tensors_and_metadata_are_named() {
        let bytes = [0.0f32; 2].map(f32::to_le_bytes).concat();
        let view = || TensorView::new(Dtype::F32, vec![2], &bytes).unwrap();
        let without_metadata = serialize([("x", view())], None).unwrap();
        assert!(matches!(Weights::from_bytes(&without_metadata), Err(WeightsError::BadArchitecture(_))));
        let metadata = HashMap::from([("architecture".into(), text(&Weights::random(1)))]);
        let without_tensors = serialize([("x", view())], Some(metadata)).unwrap();
        let missing = WeightsError::Missing("point_sampler.dev_conv_0.theta".into());
        assert_eq!(Weights::from_bytes(&without_tensors), Err(missing));
    }

    #[test]
    fn broken_bytes_are_refused_without_panic() {
        let bytes = small().to_bytes();
        for end in [0, 1, 7, 8, 9, 100, bytes.len() - 1] {
            assert!(matches!(Weights::from_bytes(&bytes[..end]), Err(WeightsError::NotSafetensors(_))));
        }
        let mut huge = bytes.clone();
        huge[..8].fill(255);
        assert!(Weights::from_bytes(&huge).is_err());
    }
}
