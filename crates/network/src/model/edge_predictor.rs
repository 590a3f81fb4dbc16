//! Edge Predictor, Sec. 3.2.

use super::{DevConv, SparseAttention, dev_conv, sparse_attention};
use crate::autodiff::{Tape, Value};
use crate::linalg::Csr;
use std::sync::Arc;

/// The Edge Predictor's two layers.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgePredictor<T> {
    /// DevConv over positions.
    pub dev_conv: DevConv<T>,
    /// Attention over the DevConv's features.
    pub attention: SparseAttention<T>,
}

/// Predictions for the edges of G_ext, n_entries x 1 each.
#[derive(Clone, Debug)]
pub struct Edges {
    /// Attention S, Eq. (2): the entries of each row sum to 1.
    pub attention: Value,
    /// Predicted adjacency A_s, Eq. (3): symmetric, not negative.
    pub adjacency: Value,
}

/// Computes `A_s[i, j] = S[i, :] A S[j, :]^T` for i, j in G_ext, Eq. (3), with S from Eq. (2).
///
/// # Shapes
/// - `points`: n x 3, the samples, scaled to mean edge length 1
/// - `graph`: n x n, G_ext, symmetric
/// - `original`: n x n, A, samples joined by the mesh, symmetric
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::{autodiff::{Tape, Value}, linalg::{Csr, Matrix}, model::{Weights, edge_predictor}};
/// use std::sync::Arc;
/// let weights = Weights::random(1);
/// let points = Value::constant(Matrix::new(2, 3, vec![0.0, 0.0, 0.0, 0.5, 0.0, 0.0]));
/// let edge = Arc::new(Csr::from_edges(2, [[0, 1]]));
/// let edges = edge_predictor(&mut Tape::default(), &weights.constants().edge_predictor, &points, &edge, &edge);
/// assert_eq!(edges.adjacency.matrix().data(), [1.0, 1.0]);
/// ```
pub fn edge_predictor(
    tape: &mut Tape,
    net: &EdgePredictor<Value>,
    points: &Value,
    graph: &Arc<Csr>,
    original: &Arc<Csr>,
) -> Edges {
    let features = dev_conv(tape, &net.dev_conv, points, graph);
    let attention = sparse_attention(tape, &net.attention, &features, graph);
    let adjacency = tape.sparse_product(&attention, graph, original);
    Edges { attention, adjacency }
}

impl<T> EdgePredictor<T> {
    /// Applies `f(name, tensor)` to every tensor in a fixed order, until `f` fails; names begin with `name`.
    ///
    /// ```
    /// # use neural_mesh_network as neural_mesh;
    /// use neural_mesh::model::Architecture;
    /// let mut names = Vec::new();
    /// let stage = Architecture::default().shapes().edge_predictor;
    /// stage.try_map("predictor", &mut |name, _| Ok::<_, ()>(names.push(name.to_string()))).unwrap();
    /// assert_eq!(names[0], "predictor.dev_conv.theta");
    /// ```
    pub fn try_map<U, E>(
        &self,
        name: &str,
        f: &mut impl FnMut(&str, &T) -> Result<U, E>,
    ) -> Result<EdgePredictor<U>, E> {
        Ok(EdgePredictor {
            dev_conv: self.dev_conv.try_map(&format!("{name}.dev_conv"), f)?,
            attention: self.attention.try_map(&format!("{name}.attention"), f)?,
        })
    }
}
