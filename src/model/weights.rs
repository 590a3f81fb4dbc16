//! The network's weights: drawn from a seed or made of tensors; `weights_file` reads and writes them.

use super::{Architecture, Network};
use crate::autodiff::{Tape, Tensors, Value, WeightsError};
use crate::linalg::Matrix;
use std::sync::Arc;

/// Mean number of candidates that share an edge with one of six per sample: TOSCA, ratios of 0.05 to 0.5.
const ACROSS_EDGES: usize = 9;

/// Finite weights whose shapes are those of their architecture.
///
/// ```
/// use neural_mesh::model::Weights;
/// let weights = Weights::random(7);
/// assert_eq!(weights.architecture().n_parameters(), 14_658);
/// assert_ne!(weights, Weights::random(8));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Weights {
    architecture: Architecture,
    tensors: Network<Arc<Matrix>>,
    /// What they learned, where that is known.
    objective: Option<String>,
}

/// How the word in the text of an architecture begins that says what was learned.
pub(super) const OBJECTIVE: &str = "objective=";

impl Weights {
    /// Draws weights of the default sizes, ready for training; see [`Weights::random_of`].
    pub fn random(seed: u64) -> Self {
        Self::random_of(Architecture::default(), seed)
    }

    /// Draws weights uniformly with variance `2 / n_in` (He et al. 2015, for layers before a ReLU), biases zero.
    ///
    /// The last layer of a TriConv adds up over neighbours what is never negative, so that its sum grows in proportion
    /// to their number: its weights are divided by it. The classifier's own last layer starts at a tenth, for
    /// probabilities near one half: a sigmoid that starts at 0 or 1 hardly lets a gradient through.
    pub fn random_of(architecture: Architecture, seed: u64) -> Self {
        let n_neighbours = match architecture.face_knn {
            0 => ACROSS_EDGES,
            k => k,
        };
        let share = |name: &str| match name {
            _ if name.contains("tri_conv") && name.ends_with(".output.weights") => 1.0 / n_neighbours as f32,
            "face_classifier.output.weights" => 0.1,
            _ => 1.0,
        };
        let drawn = architecture.shapes().named().draw_scaled(seed, share);
        let tensors = architecture.shapes().of(&drawn).expect("all that were drawn");
        Self { architecture, tensors: looking_at_itself(tensors), objective: None }
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
        Self::from_named(architecture, &tensors.named())
    }

    /// The same of tensors by name, in any order; others are passed over.
    ///
    /// # Errors
    /// [`WeightsError`] names the first tensor that is wrong.
    ///
    /// ```
    /// use neural_mesh::model::Weights;
    /// let weights = Weights::random(7);
    /// assert_eq!(Weights::from_named(*weights.architecture(), &weights.tensors().named()), Ok(weights));
    /// ```
    pub fn from_named(architecture: Architecture, tensors: &Tensors<Arc<Matrix>>) -> Result<Self, WeightsError> {
        let shapes = architecture.shapes();
        let tensors = shapes.of(&tensors.check_shapes(&shapes.named())?)?;
        Ok(Self { architecture, tensors, objective: None })
    }

    /// The sizes of the network.
    pub fn architecture(&self) -> &Architecture {
        &self.architecture
    }

    /// All tensors.
    pub fn tensors(&self) -> &Network<Arc<Matrix>> {
        &self.tensors
    }

    /// The objective that they were trained with, where the file says so.
    pub fn objective(&self) -> Option<&str> {
        self.objective.as_deref()
    }

    /// These weights as those that learned an objective, a word, which their file then says.
    ///
    /// ```
    /// use neural_mesh::model::Weights;
    /// let weights = Weights::random(7).learned("shape");
    /// assert_eq!(Weights::from_bytes(&weights.to_bytes()).unwrap().objective(), Some("shape"));
    /// ```
    pub fn learned(self, objective: &str) -> Self {
        Self { objective: Some(objective.split_whitespace().collect::<Vec<_>>().join("-")), ..self }
    }

    /// These weights with the objective that the text of an architecture states, if it does.
    pub(super) fn with_objective_of(self, text: &str) -> Self {
        match text.split_whitespace().find_map(|word| word.strip_prefix(OBJECTIVE)) {
            Some(objective) => self.learned(objective),
            None => self,
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tensors_that_are_wrong_are_refused() {
        let weights = Weights::random_of(Architecture::TINY, 1);
        let wider = Architecture { face_classifier_width: 7, ..weights.architecture };
        let refused = Weights::from_tensors(wider, weights.tensors.clone()).unwrap_err();
        assert!(matches!(refused, WeightsError::WrongShape { name, .. } if name.starts_with("face_classifier")));
        let deeper = Architecture { face_classifier_layers: 3, ..weights.architecture };
        let refused = Weights::from_tensors(deeper, weights.tensors.clone()).unwrap_err();
        assert!(matches!(refused, WeightsError::Missing(name) if name.contains("tri_conv_2")));
        let infinite =
            weights.tensors.map(|_, m| Arc::new(Matrix::from_fn(m.shape()[0], m.shape()[1], |_, _| f32::INFINITY)));
        let refused = Weights::from_tensors(weights.architecture, infinite).unwrap_err();
        assert!(matches!(refused, WeightsError::NotFinite(name) if name.starts_with("point_sampler")));
    }
}
