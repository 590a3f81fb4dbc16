//! The network's weights: drawn from a seed, or read from and written to the bytes of a safetensors file.

use super::{Architecture, Network};
use crate::autodiff::{Tape, Value};
use crate::linalg::Matrix;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};
use safetensors::tensor::{Dtype, SafeTensors, TensorView, serialize};
use std::collections::HashMap;
use std::sync::Arc;

/// Finite weights whose shapes are those of their architecture.
///
/// ```
/// use neural_mesh::model::Weights;
/// let weights = Weights::random(7);
/// assert_eq!(Weights::from_bytes(&weights.to_bytes()).unwrap(), weights);
/// assert!(Weights::from_bytes(b"no weights").is_err());
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Weights {
    architecture: Architecture,
    tensors: Network<Arc<Matrix>>,
}

/// Why bytes are not weights.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum WeightsError {
    /// Not a safetensors file; the text says where it fails.
    NotSafetensors(String),
    /// The metadata do not state the sizes of the network; the text says what is wrong.
    BadArchitecture(String),
    /// A tensor is missing.
    Missing(String),
    /// A tensor is not made of `f32`.
    NotF32(String),
    /// A tensor has another shape than the sizes ask for.
    WrongShape {
        /// Name of the tensor.
        name: String,
        /// Rows and columns asked for.
        expected: [usize; 2],
        /// The shape in the file.
        found: Vec<usize>,
    },
    /// A tensor holds an infinite entry or one that is not a number.
    NotFinite(String),
}

impl std::fmt::Display for WeightsError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NotSafetensors(why) => write!(f, "not a safetensors file ({why}): give weights of this program"),
            Self::BadArchitecture(why) => write!(f, "the weights' metadata `{ARCHITECTURE_KEY}` {why}"),
            Self::Missing(name) => write!(f, "the weights lack the tensor `{name}`: they are of another network"),
            Self::NotF32(name) => write!(f, "the tensor `{name}` is not of type F32: convert the weights"),
            Self::WrongShape { name, expected, found } => {
                write!(f, "the tensor `{name}` has shape {found:?}, the network's sizes ask for {expected:?}")
            }
            Self::NotFinite(name) => write!(f, "the tensor `{name}` has entries that are not finite: train again"),
        }
    }
}

impl std::error::Error for WeightsError {}

const ARCHITECTURE_KEY: &str = "architecture";

impl Weights {
    /// Draws weights of the paper's sizes, ready for training; see [`Weights::random_of`].
    pub fn random(seed: u64) -> Self {
        Self::random_of(Architecture::default(), seed)
    }

    /// Draws weights uniformly with variance `2 / n_in` (He et al. 2015, for layers before a ReLU), biases zero.
    ///
    /// The last layer of a TriConv adds up over neighbours what is never negative, so that its sum grows in proportion
    /// to their number: its weights are divided by it. The classifier's own last layer starts at a tenth, for
    /// probabilities near one half: a sigmoid that starts at 0 or 1 hardly lets a gradient through.
    pub fn random_of(architecture: Architecture, seed: u64) -> Self {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut uniform = || (rng.next_u64() >> 40) as f32 / (1u64 << 23) as f32 - 1.0;
        let tensors = architecture.shapes().map(|name, &[n_in, n_out]| {
            if name.ends_with(".bias") {
                return Arc::new(Matrix::zeros(n_in, n_out));
            }
            let is_summed = name.contains("tri_conv") && name.ends_with(".output.weights");
            let share = match name {
                _ if is_summed => 1.0 / architecture.face_knn as f32,
                "face_classifier.output.weights" => 0.1,
                _ => 1.0,
            };
            let limit = share * (6.0 / n_in as f32).sqrt();
            Arc::new(Matrix::from_fn(n_in, n_out, |_, _| limit * uniform()))
        });
        Self { architecture, tensors: looking_at_itself(tensors) }
    }

    /// Reads a safetensors file, checking sizes, shapes and numbers. Tensors of other names are passed over.
    ///
    /// # Errors
    /// [`WeightsError`] names the first thing that is wrong.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, WeightsError> {
        let not_safetensors = |error: safetensors::SafeTensorError| WeightsError::NotSafetensors(error.to_string());
        let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(not_safetensors)?;
        let text = metadata.metadata().as_ref().and_then(|entries| entries.get(ARCHITECTURE_KEY));
        let text = text.ok_or(WeightsError::BadArchitecture("is missing: they are of another program".into()))?;
        let architecture = Architecture::from_text(text).map_err(WeightsError::BadArchitecture)?;
        let file = SafeTensors::deserialize(bytes).map_err(not_safetensors)?;
        let tensors = architecture.shapes().try_map(|name, &shape| read_tensor(&file, name, shape))?;
        Ok(Self { architecture, tensors })
    }

    /// Weights made of tensors, checking shapes and numbers: what an optimiser hands back.
    ///
    /// # Errors
    /// [`WeightsError`] names the first tensor that is wrong.
    ///
    /// ```
    /// use neural_mesh::model::Weights;
    /// let weights = Weights::random(7);
    /// let same = Weights::from_tensors(*weights.architecture(), weights.tensors().clone());
    /// assert_eq!(same, Ok(weights));
    /// ```
    pub fn from_tensors(architecture: Architecture, tensors: Network<Arc<Matrix>>) -> Result<Self, WeightsError> {
        let mut found: HashMap<String, Arc<Matrix>> = HashMap::new();
        tensors.map(|name, matrix| found.insert(name.into(), matrix.clone()));
        let tensors = architecture.shapes().try_map(|name, &expected| match found.remove(name) {
            None => Err(WeightsError::Missing(name.into())),
            Some(matrix) if matrix.shape() != expected => {
                Err(WeightsError::WrongShape { name: name.into(), expected, found: matrix.shape().to_vec() })
            }
            Some(matrix) if !matrix.data().iter().all(|x| x.is_finite()) => Err(WeightsError::NotFinite(name.into())),
            Some(matrix) => Ok(matrix),
        })?;
        Ok(Self { architecture, tensors })
    }

    /// Writes a safetensors file: `f32` tensors, n_in x n_out, with the sizes in the metadata. Equal weights give
    /// equal bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut tensors: Vec<(String, [usize; 2], Vec<u8>)> = Vec::new();
        self.tensors.map(|name, matrix| {
            let bytes = matrix.data().iter().flat_map(|x| x.to_le_bytes()).collect();
            tensors.push((name.to_string(), matrix.shape(), bytes));
        });
        let views = tensors.iter().map(|(name, shape, bytes)| {
            let view = TensorView::new(Dtype::F32, shape.to_vec(), bytes).expect("as many bytes as the shape says");
            (name, view)
        });
        let metadata = HashMap::from([(ARCHITECTURE_KEY.to_string(), self.architecture.to_text())]);
        serialize(views, Some(metadata)).expect("tensors that fit their shapes")
    }

    /// The sizes of the network.
    pub fn architecture(&self) -> &Architecture {
        &self.architecture
    }

    /// All tensors.
    pub fn tensors(&self) -> &Network<Arc<Matrix>> {
        &self.tensors
    }

    /// The network for inference: nothing is recorded. Matrices are shared, not copied.
    pub fn constants(&self) -> Network<Value> {
        self.tensors.map(|_, matrix| Value::constant(matrix.clone()))
    }

    /// The network for training: every tensor is a parameter of the tape.
    pub fn parameters(&self, tape: &mut Tape) -> Network<Value> {
        self.tensors.map(|_, matrix| tape.parameter(matrix.clone()))
    }
}

/// Starts the keys of the attention where its queries are: each sample then looks most at those that are like it,
/// itself first, and A_s starts out as the original connectivity.
fn looking_at_itself(mut tensors: Network<Arc<Matrix>>) -> Network<Arc<Matrix>> {
    let attention = &mut tensors.edge_predictor.attention;
    attention.key = attention.query.clone();
    tensors
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
    let entries: Vec<f32> = words.iter().map(|word| f32::from_le_bytes(*word)).collect();
    if !entries.iter().all(|x| x.is_finite()) {
        return Err(WeightsError::NotFinite(name.into()));
    }
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
        let tensors = weights.tensors.map(|name, matrix| Arc::new(change(name, matrix)));
        Weights { tensors, ..weights.clone() }.to_bytes()
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
    fn tensors_of_other_sizes_are_refused() {
        let weights = small();
        let wider = Architecture { face_classifier_width: 7, ..weights.architecture };
        let refused = Weights::from_tensors(wider, weights.tensors.clone()).unwrap_err();
        assert!(matches!(refused, WeightsError::WrongShape { name, .. } if name.starts_with("face_classifier")));
        let deeper = Architecture { face_classifier_layers: 2, ..weights.architecture };
        let refused = Weights::from_tensors(deeper, weights.tensors).unwrap_err();
        assert!(matches!(refused, WeightsError::Missing(name) if name.contains("tri_conv_1")));
    }

    #[test]
    fn missing_tensors_and_metadata_are_named() {
        let bytes = [0.0f32; 2].map(f32::to_le_bytes).concat();
        let view = || TensorView::new(Dtype::F32, vec![2], &bytes).unwrap();
        let without_metadata = serialize([("x", view())], None).unwrap();
        assert!(matches!(Weights::from_bytes(&without_metadata), Err(WeightsError::BadArchitecture(_))));
        let metadata = HashMap::from([(ARCHITECTURE_KEY.into(), Architecture::default().to_text())]);
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
