//! Weights of the network.

use super::{Architecture, Network};
use crate::autodiff::{Tape, Tensors, Value, WeightsError};
use crate::linalg::Matrix;
use std::sync::Arc;

/// Assumed number of edge neighbours of a candidate, by which initial weights are scaled down.
const ACROSS_EDGES: usize = 9;

/// Finite weights whose shapes match their architecture.
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::model::Weights;
/// let weights = Weights::random(7);
/// assert_eq!(weights.architecture().n_parameters(), 14_658);
/// assert_ne!(weights, Weights::random(8));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Weights {
    architecture: Architecture,
    tensors: Network<Arc<Matrix>>,
    objective: Option<String>,
}

pub(super) const OBJECTIVE: &str = "objective=";

impl Weights {
    /// Draws weights of the default sizes; see [`Weights::random_of`].
    pub fn random(seed: u64) -> Self {
        Self::random_of(Architecture::default(), seed)
    }

    /// Draws uniform weights with variance `2 / n_in` (He et al. 2015) and zero biases.
    ///
    /// The output maps of each TriConv and of the classifier get smaller weights.
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
        let drawn = architecture.shapes().named_tensors().draw_scaled(seed, share);
        let tensors = architecture.shapes().with_tensors(&drawn).expect("all that were drawn");
        Self { architecture, tensors: looking_at_itself(tensors), objective: None }
    }

    /// Builds weights from tensors.
    ///
    /// # Errors
    /// [`WeightsError`] names the first tensor of wrong shape or not finite.
    ///
    /// ```
    /// # use neural_mesh_network as neural_mesh;
    /// use neural_mesh::model::Weights;
    /// let weights = Weights::random(7);
    /// let same = Weights::from_tensors(*weights.architecture(), weights.tensors().clone());
    /// assert_eq!(same, Ok(weights));
    /// ```
    pub fn from_tensors(architecture: Architecture, tensors: Network<Arc<Matrix>>) -> Result<Self, WeightsError> {
        Self::from_named(architecture, &tensors.named_tensors())
    }

    /// Builds weights from named tensors in any order, ignoring others.
    ///
    /// # Errors
    /// [`WeightsError`] names the first faulty tensor.
    ///
    /// ```
    /// # use neural_mesh_network as neural_mesh;
    /// use neural_mesh::model::Weights;
    /// let weights = Weights::random(7);
    /// assert_eq!(Weights::from_named(*weights.architecture(), &weights.tensors().named_tensors()), Ok(weights));
    /// ```
    pub fn from_named(architecture: Architecture, tensors: &Tensors<Arc<Matrix>>) -> Result<Self, WeightsError> {
        let shapes = architecture.shapes();
        let tensors = shapes.with_tensors(&tensors.check_shapes(&shapes.named_tensors())?)?;
        Ok(Self { architecture, tensors, objective: None })
    }

    /// Returns the sizes of the network.
    pub fn architecture(&self) -> &Architecture {
        &self.architecture
    }

    /// Returns all tensors.
    pub fn tensors(&self) -> &Network<Arc<Matrix>> {
        &self.tensors
    }

    /// Returns the name of the training objective, if the file states it.
    pub fn objective(&self) -> Option<&str> {
        self.objective.as_deref()
    }

    /// Sets the name of the training objective.
    ///
    /// ```
    /// # use neural_mesh_network as neural_mesh;
    /// use neural_mesh::model::Weights;
    /// let weights = Weights::random(7).with_objective("shape");
    /// assert_eq!(Weights::from_bytes(&weights.to_bytes()).unwrap().objective(), Some("shape"));
    /// ```
    pub fn with_objective(self, objective: &str) -> Self {
        Self { objective: Some(objective.split_whitespace().collect::<Vec<_>>().join("-")), ..self }
    }

    pub(super) fn with_objective_of(self, text: &str) -> Self {
        match text.split_whitespace().find_map(|word| word.strip_prefix(OBJECTIVE)) {
            Some(objective) => self.with_objective(objective),
            None => self,
        }
    }

    /// Returns the network for inference; matrices are shared.
    pub fn constants(&self) -> Network<Value> {
        self.tensors.map(|_, matrix| Value::constant(matrix.clone()))
    }

    /// Returns the network for training, with every tensor a parameter of the tape.
    pub fn parameters(&self, tape: &mut Tape) -> Network<Value> {
        self.tensors.map(|_, matrix| tape.parameter(matrix.clone()))
    }
}

/// Sets the attention's keys to its queries, so that each sample attends most to itself.
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
