//! Edge Predictor, Sec. 3.2, with gradients.

use super::{column, gradient_of_points, numbers};
use crate::autodiff::{Tape, Value};
use crate::linalg::{Csr, Matrix};
use crate::model::{EdgePredictor, Edges, Weights, edge_predictor};
use std::convert::Infallible;
use std::sync::Arc;

/// Predicted edges of the samples, with the data for the backward pass.
pub struct EdgePredictorPass {
    /// S, Eq. (2), one value per entry of the graph.
    pub attention: Vec<f32>,
    /// A_s, Eq. (3), one value per entry of the graph.
    pub adjacency: Vec<f32>,
    tape: Tape,
    net: EdgePredictor<Value>,
    points: Value,
    edges: Edges,
}

/// Gradients of a loss that depends on S and A_s.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgePredictorGradients {
    /// Gradient by each tensor.
    pub tensors: EdgePredictor<Matrix>,
    /// Gradient by the samples' positions.
    pub points: Vec<[f32; 3]>,
}

/// Predicts the edges of the extended graph and records the operations.
///
/// # Shapes
/// - `points`: the samples, scaled to mean edge length 1
/// - `graph`: n x n, from [`extended_graph`](crate::model::extended_graph), symmetric
/// - `original`: n x n, samples joined by the mesh, symmetric
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::{linalg::Csr, model::{Weights, edge_predictor_backward, edge_predictor_forward}};
/// use std::sync::Arc;
/// let points = [[0.0; 3], [0.6, 0.0, 0.0], [0.0, 0.6, 0.0]];
/// let graph = Arc::new(Csr::from_edges(3, [[0, 1], [1, 2], [2, 0]]));
/// let pass = edge_predictor_forward(&Weights::random(1), &points, &graph, &graph);
/// // Each row of S sums to 1 whatever the weights are.
/// let gradients = edge_predictor_backward(&pass, &[1.0; 6], &[0.0; 6]);
/// assert!(gradients.tensors.attention.query.data().iter().all(|g| g.abs() < 1e-6));
/// ```
pub fn edge_predictor_forward(
    weights: &Weights,
    points: &[[f32; 3]],
    graph: &Arc<Csr>,
    original: &Arc<Csr>,
) -> EdgePredictorPass {
    let mut tape = Tape::default();
    let Ok(net) =
        weights.tensors().edge_predictor.try_map("", &mut |_, m| Ok::<_, Infallible>(tape.parameter(m.clone())));
    let points = tape.parameter(Matrix::from_points(points));
    let edges = edge_predictor(&mut tape, &net, &points, graph, original);
    let [attention, adjacency] = [&edges.attention, &edges.adjacency].map(numbers);
    EdgePredictorPass { attention, adjacency, tape, net, points, edges }
}

/// Computes the gradients of [`edge_predictor_forward`] from those of S and A_s.
pub fn edge_predictor_backward(
    pass: &EdgePredictorPass,
    gradient_of_attention: &[f32],
    gradient_of_adjacency: &[f32],
) -> EdgePredictorGradients {
    let Edges { attention, adjacency } = &pass.edges;
    let gradients =
        pass.tape.backward(&[(attention, column(gradient_of_attention)), (adjacency, column(gradient_of_adjacency))]);
    let Ok(tensors) = pass.net.try_map("", &mut |_, value| Ok::<_, Infallible>(gradients.or_zero(value)));
    EdgePredictorGradients { tensors, points: gradient_of_points(&gradients, &pass.points) }
}
