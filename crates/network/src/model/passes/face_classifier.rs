//! Face Classifier, Sec. 3.3, with gradients.

use super::{column, gradient_of_points, numbers};
use crate::autodiff::{Tape, Value};
use crate::linalg::{Csr, Matrix};
use crate::model::{FaceClassifier, Weights, face_classifier};
use std::convert::Infallible;
use std::sync::Arc;

/// Probabilities, with the data for the backward pass.
pub struct FaceClassifierPass {
    /// Probability of each triangle, in 0..=1.
    pub probabilities: Vec<f32>,
    tape: Tape,
    net: FaceClassifier<Value>,
    points: Value,
    prior: Value,
    result: Value,
}

/// Gradients of a loss that depends on the probabilities.
#[derive(Clone, Debug, PartialEq)]
pub struct FaceClassifierGradients {
    /// Gradient by each tensor.
    pub tensors: FaceClassifier<Matrix>,
    /// Gradient by the samples' positions.
    pub points: Vec<[f32; 3]>,
    /// Gradient by the prior.
    pub prior: Vec<f32>,
}

/// Classifies triangles and records the operations.
///
/// # Shapes
/// - `points`: the samples, scaled to mean edge length 1
/// - `triangles`: corners ascending by original vertex
/// - `graph`: from [`triangle_graph`](crate::model::triangle_graph)
/// - `prior`: n_triangles
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::model::{Weights, face_classifier_backward, face_classifier_forward, triangle_graph};
/// let points = [[0.0; 3], [0.5, 0.0, 0.0], [0.0, 0.5, 0.0], [0.5, 0.5, 0.0]];
/// let triangles = [[0, 1, 2], [1, 2, 3]];
/// let graph = triangle_graph(&points, &triangles, 20).into();
/// let pass = face_classifier_forward(&Weights::random(1), &points, &triangles, &graph, &[0.5, 0.25]);
/// let gradients = face_classifier_backward(&pass, &[1.0, 0.0]);
/// // Only differences of priors and of positions matter.
/// assert!((gradients.prior[0] + gradients.prior[1]).abs() < 1e-6);
/// ```
pub fn face_classifier_forward(
    weights: &Weights,
    points: &[[f32; 3]],
    triangles: &[[u32; 3]],
    graph: &Arc<Csr>,
    prior: &[f32],
) -> FaceClassifierPass {
    let mut tape = Tape::default();
    let Ok(net) =
        weights.tensors().face_classifier.try_map("", &mut |_, m| Ok::<_, Infallible>(tape.parameter(m.clone())));
    let [points, prior] = [Matrix::from_points(points), column(prior)].map(|matrix| tape.parameter(matrix));
    let result = face_classifier(&mut tape, &net, &points, triangles, graph, &prior);
    FaceClassifierPass { probabilities: numbers(&result), tape, net, points, prior, result }
}

/// Computes the gradients of [`face_classifier_forward`] from those of the probabilities.
pub fn face_classifier_backward(
    pass: &FaceClassifierPass,
    gradient_of_probabilities: &[f32],
) -> FaceClassifierGradients {
    let gradients = pass.tape.backward(&[(&pass.result, column(gradient_of_probabilities))]);
    let Ok(tensors) = pass.net.try_map("", &mut |_, value| Ok::<_, Infallible>(gradients.or_zero(value)));
    let points = gradient_of_points(&gradients, &pass.points);
    FaceClassifierGradients { tensors, points, prior: gradients.or_zero(&pass.prior).into_data() }
}
