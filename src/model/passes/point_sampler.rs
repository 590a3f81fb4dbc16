//! The Point Sampler, Sec. 3.1, with gradients.

use super::{column, gradient_of, gradient_of_points, numbers};
use crate::autodiff::{Tape, Value};
use crate::linalg::{Csr, Matrix};
use crate::model::{PointSampler, Weights, point_sampler};
use std::convert::Infallible;
use std::sync::Arc;

/// Scores, and what the way back needs.
pub struct PointSamplerPass {
    /// One score per vertex.
    pub scores: Vec<f32>,
    tape: Tape,
    net: PointSampler<Value>,
    points: Value,
    result: Value,
}

/// Gradients of a loss over the scores.
#[derive(Clone, Debug, PartialEq)]
pub struct PointSamplerGradients {
    /// To every tensor.
    pub tensors: PointSampler<Matrix>,
    /// To the positions, n x 3.
    pub points: Vec<[f32; 3]>,
}

/// Scores every vertex, as [`vertex_scores`](crate::model::vertex_scores) does, and remembers the way.
///
/// # Shapes
/// - `points`: n x 3, from [`normalized`](crate::model::normalized)
/// - `rings`: n x n, the edges of the mesh
///
/// # Panics
/// When `rings` has another number of rows.
///
/// ```
/// use neural_mesh::{linalg::Csr, model::{Weights, normalized, point_sampler_backward, point_sampler_forward}};
/// let points = normalized(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
/// let rings = Csr::from_edges(3, [[0, 1], [1, 2], [2, 0]]).into();
/// let pass = point_sampler_forward(&Weights::random(1), &points, &rings);
/// let gradients = point_sampler_backward(&pass, &[1.0, 0.0, 0.0]);
/// assert_eq!((pass.scores.len(), gradients.points.len()), (3, 3));
/// // The bias is added to every score.
/// assert_eq!(gradients.tensors.score.bias.data(), [1.0]);
/// ```
pub fn point_sampler_forward(weights: &Weights, points: &[[f32; 3]], rings: &Arc<Csr>) -> PointSamplerPass {
    let mut tape = Tape::default();
    let Ok(net) =
        weights.tensors().point_sampler.try_map("", &mut |_, m| Ok::<_, Infallible>(tape.parameter(m.clone())));
    let points = tape.parameter(Matrix::from_points(points));
    let result = point_sampler(&mut tape, &net, &points, rings);
    PointSamplerPass { scores: numbers(&result), tape, net, points, result }
}

/// Gradients from those of the scores, n.
///
/// # Panics
/// When there is not one gradient per score.
///
/// See [`point_sampler_forward`] for an example.
pub fn point_sampler_backward(pass: &PointSamplerPass, gradient_of_scores: &[f32]) -> PointSamplerGradients {
    let gradients = pass.tape.backward(&[(&pass.result, column(gradient_of_scores))]);
    let Ok(tensors) = pass.net.try_map("", &mut |_, value| Ok::<_, Infallible>(gradient_of(&gradients, value)));
    PointSamplerGradients { tensors, points: gradient_of_points(&gradients, &pass.points) }
}
