//! DevConv, Eq. (1) of Sec. 3.1.

use crate::autodiff::{Tape, Value};
use crate::linalg::Csr;
use std::sync::Arc;

/// The two linear maps of a DevConv, one row per input; without bias as in the paper.
#[derive(Clone, Debug, PartialEq)]
pub struct DevConv<T> {
    /// `W_theta`, n_in x width, applied to the differences between a vertex and its neighbours.
    pub theta: T,
    /// `W_phi`, width x width, applied to the maximum over the neighbours.
    pub phi: T,
}

/// Computes `f_i = ReLU(W_phi max_{j in N(i)} W_theta (x_i - x_j))`, Eq. (1); zero without neighbours.
///
/// # Shapes
/// - `x`: n x n_in, positions or features; `graph`: n x n
/// - returns n x width
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::autodiff::{Tape, Value};
/// use neural_mesh::linalg::{Csr, Matrix};
/// use neural_mesh::model::{DevConv, dev_conv};
/// let scalar = |x: f32| Value::constant(Matrix::new(1, 1, vec![x]));
/// let layer = DevConv { theta: scalar(2.0), phi: scalar(10.0) };
/// let x = Value::constant(Matrix::new(3, 1, vec![1.0, 4.0, 2.0]));
/// let path = Csr::from_edges(3, [[0, 1], [1, 2]]).into();
/// // Vertex 1 is 3 above one neighbour and 2 above the other; the ends lie below their neighbours.
/// assert_eq!(dev_conv(&mut Tape::default(), &layer, &x, &path).matrix().data(), [0.0, 60.0, 0.0]);
/// ```
pub fn dev_conv(tape: &mut Tape, layer: &DevConv<Value>, x: &Value, graph: &Arc<Csr>) -> Value {
    let mapped = tape.product(x, &layer.theta);
    tape.neighbour_max_product_relu(&mapped, graph, &layer.phi)
}

/// Computes [`dev_conv`] of `[points | normals]` without storing the joined matrix.
pub(super) fn dev_conv_with_normals(
    tape: &mut Tape,
    layer: &DevConv<Value>,
    [points, normals]: [&Value; 2],
    graph: &Arc<Csr>,
) -> Value {
    let mapped = tape.concat_product(points, normals, &layer.theta);
    tape.neighbour_max_product_relu(&mapped, graph, &layer.phi)
}

impl DevConv<[usize; 2]> {
    pub(super) fn shape(n_in: usize, width: usize) -> Self {
        Self { theta: [n_in, width], phi: [width, width] }
    }
}

impl<T> DevConv<T> {
    pub(super) fn try_map<U, E>(
        &self,
        name: &str,
        f: &mut impl FnMut(&str, &T) -> Result<U, E>,
    ) -> Result<DevConv<U>, E> {
        Ok(DevConv { theta: f(&format!("{name}.theta"), &self.theta)?, phi: f(&format!("{name}.phi"), &self.phi)? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::Matrix;
    use crate::linalg::test_values::{assert_close, ragged_graph, random};

    #[test]
    fn agrees_with_the_equation_edge_by_edge() {
        let (x, graph) = (random(40, 3, 1), Arc::new(ragged_graph(40)));
        let (theta, phi) = (random(3, 8, 2), random(8, 8, 3));
        let map = |w: &Matrix, v: &[f32]| -> Vec<f32> {
            (0..w.n_cols()).map(|c| v.iter().enumerate().map(|(k, v)| v * w.row(k)[c]).sum()).collect()
        };
        let naive = (0..40).flat_map(|i| {
            let difference =
                |j: &u32| -> Vec<f32> { x.row(i).iter().zip(x.row(*j as usize)).map(|(a, b)| a - b).collect() };
            let mapped = graph.row(i).iter().map(|j| map(&theta, &difference(j)));
            let largest = mapped.reduce(|a, b| a.iter().zip(b).map(|(a, b)| a.max(b)).collect());
            map(&phi, &largest.unwrap_or(vec![0.0; 8])).into_iter().map(|y| y.max(0.0))
        });
        let layer = DevConv { theta: Value::constant(theta.clone()), phi: Value::constant(phi.clone()) };
        let result = dev_conv(&mut Tape::default(), &layer, &Value::constant(x.clone()), &graph);
        assert_close(result.matrix().data(), &naive.collect::<Vec<_>>(), 1e-5);
    }
}
