//! What a training step takes and gives; the steps themselves have files of their own.

use super::Settings;
use crate::autodiff::{Gradients, Tensors, Value};
use crate::linalg::Matrix;
use crate::mesh::TriMesh;
use crate::model::{Network, Weights};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::sync::Arc;

/// What a step works on.
#[derive(Clone, Debug, PartialEq)]
pub struct Item {
    /// Name of the mesh's file.
    pub name: String,
    /// The mesh, changed as the settings say; its mean is the origin, the diagonal of its bounding box 1.
    pub mesh: TriMesh,
    /// Share of the vertices that are to stay, above 0 and at most 1.
    pub ratio: f64,
}

/// What one step found: the loss terms by name, and the gradient of their sum to every tensor.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Each with its weight in the sum, the same names in the same order at every step.
    pub terms: Vec<(&'static str, f64)>,
    /// Of the shapes of the tensors.
    pub gradients: Tensors<Matrix>,
}

/// One step: the same for the same tensors, item, settings and random state, on any number of threads. The error says
/// in a few words why the step cannot be made with this mesh; it is then named and passed over.
///
/// The tensors are those of the network that is trained, in its order; so are the gradients.
/// [`of_network`] makes one of a function of the paper's network.
pub type StepFunction<'a> =
    dyn Fn(&Tensors<Arc<Matrix>>, &Item, &Settings, &mut Xoshiro256PlusPlus) -> Result<Step, String> + 'a;

/// A step of the paper's network, whose sizes are those of the settings, as one of tensors.
///
/// ```
/// use neural_mesh::{model::Weights, train::{Item, Settings, Step, of_network}};
/// let _step = of_network(|weights: &Weights, _: &Item, _: &Settings, _: &mut _| {
///     let gradients = weights.tensors().named().map(|_, matrix| matrix.as_ref().clone());
///     Ok(Step { terms: vec![("length", 1.0)], gradients })
/// });
/// ```
pub fn of_network<'a>(
    step: impl Fn(&Weights, &Item, &Settings, &mut Xoshiro256PlusPlus) -> Result<Step, String> + 'a,
) -> Box<StepFunction<'a>> {
    Box::new(move |tensors, item, settings, random| {
        let weights = Weights::from_named(settings.architecture(), tensors).map_err(|error| error.to_string())?;
        step(&weights, item, settings, random)
    })
}

impl Step {
    /// The sum of the terms, which is what is minimised.
    pub fn total(&self) -> f64 {
        self.terms.iter().map(|(_, value)| value).sum()
    }
}

/// The gradients of a network's parameters, zero for those that the results do not depend on.
///
/// ```
/// use neural_mesh::{autodiff::Tape, linalg::Matrix, model::Weights, train::gradients_of};
/// let mut tape = Tape::default();
/// let net = Weights::random(1).parameters(&mut tape);
/// let bias = &net.point_sampler.score.bias;
/// let gradients = gradients_of(&net, &tape.backward(&[(bias, Matrix::new(1, 1, vec![3.0]))]));
/// assert_eq!(gradients.get("point_sampler.score.bias").unwrap().data(), [3.0]);
/// assert_eq!(gradients.get("point_sampler.score.weights").unwrap(), &Matrix::zeros(64, 1));
/// ```
pub fn gradients_of(parameters: &Network<Value>, gradients: &Gradients) -> Tensors<Matrix> {
    parameters.named().gradients(gradients)
}
