//! Input and result of a training step.

use super::Settings;
use crate::autodiff::{Gradients, Tensors, Value};
use crate::linalg::Matrix;
use crate::mesh::TriMesh;
use crate::model::{Network, Weights};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::sync::Arc;

/// The input of a step.
#[derive(Clone, Debug, PartialEq)]
pub struct TrainingItem {
    /// Name of the mesh's file.
    pub name: String,
    /// The augmented mesh, with mean 0 and bounding box diagonal 1.
    pub mesh: TriMesh,
    /// Share of the vertices to keep, above 0 and at most 1.
    pub ratio: f64,
}

/// The loss terms of a step and the gradient of their sum.
#[derive(Clone, Debug, PartialEq)]
pub struct StepResult {
    /// Weighted terms by name, with equal names and order at every step.
    pub terms: Vec<(&'static str, f64)>,
    /// Gradient of every tensor.
    pub gradients: Tensors<Matrix>,
}

/// A function that computes a step's loss and gradients from tensors, item, settings and random state.
///
/// Results must have the same bits on any number of threads. An error is the reason why the mesh is skipped.
pub type StepFunction<'a> =
    dyn Fn(&Tensors<Arc<Matrix>>, &TrainingItem, &Settings, &mut Xoshiro256PlusPlus) -> Result<StepResult, String> + 'a;

/// Wraps a step of the paper's network as a [`StepFunction`]; the settings give the sizes.
///
/// ```
/// use neural_mesh::{model::Weights, train::{TrainingItem, Settings, StepResult, step_from_network}};
/// let _step = step_from_network(|weights: &Weights, _: &TrainingItem, _: &Settings, _: &mut _| {
///     let gradients = weights.tensors().named_tensors().map(|_, matrix| matrix.as_ref().clone());
///     Ok(StepResult { terms: vec![("length", 1.0)], gradients })
/// });
/// ```
pub fn step_from_network<'a>(
    step: impl Fn(&Weights, &TrainingItem, &Settings, &mut Xoshiro256PlusPlus) -> Result<StepResult, String> + 'a,
) -> Box<StepFunction<'a>> {
    Box::new(move |tensors, item, settings, random| {
        let weights = Weights::from_named(settings.architecture, tensors).map_err(|error| error.to_string())?;
        step(&weights, item, settings, random)
    })
}

impl StepResult {
    /// Returns the sum of the terms, which training minimises.
    pub fn total(&self) -> f64 {
        self.terms.iter().map(|(_, value)| value).sum()
    }
}

/// Returns the gradients of a network's parameters, zero if the results do not depend on them.
///
/// ```
/// use neural_mesh::{autodiff::Tape, linalg::Matrix, model::Weights, train::network_gradients};
/// let mut tape = Tape::default();
/// let net = Weights::random(1).parameters(&mut tape);
/// let bias = &net.point_sampler.score.bias;
/// let gradients = network_gradients(&net, &tape.backward(&[(bias, Matrix::new(1, 1, vec![3.0]))]));
/// assert_eq!(gradients.get("point_sampler.score.bias").unwrap().data(), [3.0]);
/// assert_eq!(gradients.get("point_sampler.score.weights").unwrap(), &Matrix::zeros(32, 1));
/// ```
pub fn network_gradients(parameters: &Network<Value>, gradients: &Gradients) -> Tensors<Matrix> {
    parameters.named_tensors().gradients(gradients)
}
