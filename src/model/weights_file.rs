//! Weights as the bytes of a safetensors file.

use super::weights::{ARCHITECTURE_KEY, OBJECTIVE};
use super::{Architecture, Network, Weights, WeightsError};
use crate::linalg::Matrix;
use safetensors::tensor::{Dtype, SafeTensors, TensorView, serialize};
use std::collections::HashMap;
use std::sync::Arc;

impl Weights {
    /// Reads a safetensors file, checking sizes, shapes and numbers. Tensors of other names are passed over.
    ///
    /// # Errors
    /// [`WeightsError`] names the first thing that is wrong.
    ///
    /// ```
    /// use neural_mesh::model::Weights;
    /// let weights = Weights::random(7);
    /// assert_eq!(Weights::from_bytes(&weights.to_bytes()).unwrap(), weights);
    /// assert!(Weights::from_bytes(b"no weights").is_err());
    /// ```
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, WeightsError> {
        let not_safetensors = |error: safetensors::SafeTensorError| WeightsError::NotSafetensors(error.to_string());
        let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(not_safetensors)?;
        let text = metadata.metadata().as_ref().and_then(|entries| entries.get(ARCHITECTURE_KEY));
        let text = text.ok_or(WeightsError::BadArchitecture("is missing: another program wrote them".into()))?;
        let architecture = Architecture::from_text(text).map_err(WeightsError::BadArchitecture)?;
        let file = SafeTensors::deserialize(bytes).map_err(not_safetensors)?;
        let tensors = architecture.shapes().try_map(|name, &shape| read_tensor(&file, name, shape))?;
        Ok(Self::from_tensors(architecture, tensors)?.with_objective_of(text))
    }

    /// Writes a safetensors file: `f32` tensors, n_in x n_out, with the sizes in the metadata. Equal weights give
    /// equal bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        bytes(&text(self), self.tensors())
    }
}

fn bytes(text: &str, tensors: &Network<Arc<Matrix>>) -> Vec<u8> {
    let mut parts: Vec<(String, [usize; 2], Vec<u8>)> = Vec::new();
    tensors.map(|name, matrix| {
        let bytes = matrix.data().iter().flat_map(|x| x.to_le_bytes()).collect();
        parts.push((name.to_string(), matrix.shape(), bytes));
    });
    let views = parts.iter().map(|(name, shape, bytes)| {
        let view = TensorView::new(Dtype::F32, shape.to_vec(), bytes).expect("as many bytes as the shape says");
        (name, view)
    });
    let metadata = HashMap::from([(ARCHITECTURE_KEY.to_string(), text.to_string())]);
    serialize(views, Some(metadata)).expect("tensors that fit their shapes")
}

/// The sizes as `name=size` words, and what was learned as one more: two entries would come in any order, and bytes would vary.
fn text(weights: &Weights) -> String {
    let sizes = weights.architecture().sizes().map(|(name, size)| format!("{name}={size}")).join(" ");
    weights.objective().map_or(sizes.clone(), |objective| format!("{sizes} {OBJECTIVE}{objective}"))
}

fn read_tensor(file: &SafeTensors, name: &str, expected: [usize; 2]) -> Result<Arc<Matrix>, WeightsError> {
    let tensor = file.tensor(name).map_err(|_| WeightsError::Missing(name.into()))?;
    if tensor.dtype() != Dtype::F32 {
        return Err(WeightsError::NotF32(name.into()));
    }
    if tensor.shape() != expected {
        return Err(WeightsError::WrongShape { name: name.into(), expected, found: tensor.shape().to_vec() });
    }
    let (words, _) = tensor.data().as_chunks();
    let entries = words.iter().map(|word| f32::from_le_bytes(*word)).collect();
    Ok(Arc::new(Matrix::new(expected[0], expected[1], entries)))
}

#[cfg(test)]
mod tests {
    use super::*;

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
            face_knn: 3,
        };
        Weights::random_of(sizes, 1)
    }

    /// The bytes of `weights` after a change of one tensor.
    fn bytes_with(weights: &Weights, change: impl Fn(&str, &Matrix) -> Matrix) -> Vec<u8> {
        let tensors = weights.tensors().map(|name, matrix| Arc::new(change(name, matrix)));
        bytes(&text(weights), &tensors)
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
        assert_eq!(change(Matrix::transposed), wrong_shape);
        assert_eq!(change(|_| Matrix::new(4, 1, vec![0.0, f32::NAN, 0.0, 0.0])), WeightsError::NotFinite(score.into()));
    }

    #[test]
    fn missing_tensors_and_metadata_are_named() {
        let bytes = [0.0f32; 2].map(f32::to_le_bytes).concat();
        let view = || TensorView::new(Dtype::F32, vec![2], &bytes).unwrap();
        let without_metadata = serialize([("x", view())], None).unwrap();
        assert!(matches!(Weights::from_bytes(&without_metadata), Err(WeightsError::BadArchitecture(_))));
        let metadata = HashMap::from([(ARCHITECTURE_KEY.into(), text(&Weights::random(1)))]);
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
