//! Point Sampler, Sec. 3.1, with gradients.

use super::{column, gradient_of_points, numbers};
use crate::autodiff::{Tape, Value};
use crate::linalg::{Csr, Matrix};
use crate::model::{PointSampler, Vertices, Weights, point_sampler};
use std::convert::Infallible;
use std::sync::Arc;

/// Scores, with the data for the backward pass.
pub struct PointSamplerPass {
    /// One score per vertex.
    pub scores: Vec<f32>,
    tape: Tape,
    net: PointSampler<Value>,
    points: Value,
    normals: Option<Value>,
    result: Value,
}

/// Gradients of a loss that depends on the scores.
#[derive(Clone, Debug, PartialEq)]
pub struct PointSamplerGradients {
    /// Gradient by each tensor.
    pub tensors: PointSampler<Matrix>,
    /// Gradient by the positions.
    pub points: Vec<[f32; 3]>,
    /// Gradient by the normals; empty without normals.
    pub normals: Vec<[f32; 3]>,
}

/// Scores every vertex like [`vertex_scores`](crate::model::vertex_scores) and records the operations.
///
/// # Shapes
/// - `points`: from [`in_edge_lengths`](crate::model::in_edge_lengths)
/// - `normals`: unit vectors, for networks that use them
/// - `rings`: n x n, the edges of the mesh
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::{linalg::Csr, model::{Weights, in_edge_lengths, point_sampler_backward, point_sampler_forward}};
/// let rings = std::sync::Arc::new(Csr::from_edges(3, [[0, 1], [1, 2], [2, 0]]));
/// let points = in_edge_lengths(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &rings);
/// let pass = point_sampler_forward(&Weights::random(1), &points, None, &rings);
/// let gradients = point_sampler_backward(&pass, &[1.0, 0.0, 0.0]);
/// assert_eq!((pass.scores.len(), gradients.points.len()), (3, 3));
/// // The bias is added to every score.
/// assert_eq!(gradients.tensors.score.bias.data(), [1.0]);
/// ```
pub fn point_sampler_forward(
    weights: &Weights,
    points: &[[f32; 3]],
    normals: Option<&[[f32; 3]]>,
    rings: &Arc<Csr>,
) -> PointSamplerPass {
    let mut tape = Tape::default();
    let Ok(net) =
        weights.tensors().point_sampler.try_map("", &mut |_, m| Ok::<_, Infallible>(tape.parameter(m.clone())));
    let points = tape.parameter(Matrix::from_points(points));
    let normals = normals.map(|normals| tape.parameter(Matrix::from_points(normals)));
    let result = point_sampler(&mut tape, &net, Vertices { points: &points, normals: normals.as_ref() }, rings);
    PointSamplerPass { scores: numbers(&result), tape, net, points, normals, result }
}

/// Computes the gradients of [`point_sampler_forward`] from those of the scores.
pub fn point_sampler_backward(pass: &PointSamplerPass, gradient_of_scores: &[f32]) -> PointSamplerGradients {
    let gradients = pass.tape.backward(&[(&pass.result, column(gradient_of_scores))]);
    let Ok(tensors) = pass.net.try_map("", &mut |_, value| Ok::<_, Infallible>(gradients.or_zero(value)));
    let of_rows = |rows: &Value| gradient_of_points(&gradients, rows);
    PointSamplerGradients {
        tensors,
        points: of_rows(&pass.points),
        normals: pass.normals.as_ref().map(of_rows).unwrap_or_default(),
    }
}
