//! Sparse attention, Eq. (2) of Sec. 3.2.

use crate::autodiff::{Tape, Value};
use crate::linalg::Csr;
use std::sync::Arc;

/// The linear maps of queries and keys, one row per input; without bias as in the paper.
#[derive(Clone, Debug, PartialEq)]
pub struct SparseAttention<T> {
    /// `W_q`, n_in x width.
    pub query: T,
    /// `W_k`, n_in x width.
    pub key: T,
}

/// Computes `S[i, j] = softmax_{j in N_ext(i)} (<q_i, k_j> - |k_j|^2 / 2)` with `q_i = W_q f_i`, `k_j = W_k f_j`, Eq. (2).
///
/// The paper lacks the term `|k_j|^2 / 2`, so samples with long keys attract all attention; its print also mixes up rows and
/// columns.
///
/// # Shapes
/// - `features`: n x n_in, `graph`: n x n
/// - returns n_entries x 1, one value per entry of `graph`
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::autodiff::{Tape, Value};
/// use neural_mesh::linalg::{Csr, Matrix};
/// use neural_mesh::model::{SparseAttention, sparse_attention};
/// let scalar = |x: f32| Value::constant(Matrix::new(1, 1, vec![x]));
/// let layer = SparseAttention { query: scalar(1.0), key: scalar(1.0) };
/// let features = Value::constant(Matrix::new(3, 1, vec![1.0, 1.0, 1.0 + (2.0 * 3.0_f32.ln()).sqrt()]));
/// let star = Csr::from_edges(3, [[0, 1], [0, 2]]).into();
/// let s = sparse_attention(&mut Tape::default(), &layer, &features, &star);
/// // Sample 0 weighs its neighbours exp(0) to exp(-ln 3); the others have one neighbour each.
/// assert!((s.matrix().data()[0] - 0.75).abs() < 1e-6);
/// assert_eq!(s.matrix().data()[2..], [1.0, 1.0]);
/// ```
pub fn sparse_attention(tape: &mut Tape, layer: &SparseAttention<Value>, features: &Value, graph: &Arc<Csr>) -> Value {
    let queries = tape.product(features, &layer.query);
    let keys = tape.product(features, &layer.key);
    let closeness = tape.neighbour_closeness(&queries, &keys, graph);
    tape.neighbour_softmax(&closeness, graph)
}

impl<T> SparseAttention<T> {
    pub(super) fn try_map<U, E>(
        &self,
        name: &str,
        f: &mut impl FnMut(&str, &T) -> Result<U, E>,
    ) -> Result<SparseAttention<U>, E> {
        let query = f(&format!("{name}.query"), &self.query)?;
        Ok(SparseAttention { query, key: f(&format!("{name}.key"), &self.key)? })
    }
}
