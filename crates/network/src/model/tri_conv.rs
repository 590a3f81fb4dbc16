//! TriConv, Eqs. (4) and (5) of Sec. 3.3.

use super::Affine;
use crate::autodiff::{Tape, Value};
use crate::linalg::Csr;
use std::sync::Arc;

/// Perceptron of a TriConv: `hidden`, ReLU, `output`.
#[derive(Clone, Debug, PartialEq)]
pub struct TriConv<T> {
    /// Map from 9 + n_in to width features.
    pub hidden: Affine<T>,
    /// Map from width to width features.
    pub output: Affine<T>,
}

/// Computes `[t_min | t_max | b]` of each triangle, Eq. (4).
///
/// `t_min` and `t_max` are the least and largest coordinates of `x_i - x_j`, `x_i - x_k`, `x_j - x_k`; `b` is the
/// barycenter. Corners ascend by original vertex.
///
/// # Shapes
/// - `points`: n x 3
/// - returns n_triangles x 9
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::{autodiff::{Tape, Value}, linalg::Matrix, model::triangle_positions};
/// let points = Matrix::from_points(&[[0.0; 3], [3.0, 0.0, 0.0], [0.0, 6.0, 0.0]]);
/// let rows = triangle_positions(&mut Tape::default(), &Value::constant(points), &[[0, 1, 2]]);
/// // Edges: (-3, 0, 0), (0, -6, 0), (3, -6, 0).
/// assert_eq!(rows.matrix().data(), [-3.0, -6.0, 0.0, 3.0, 0.0, 0.0, 1.0, 2.0, 0.0]);
/// ```
pub fn triangle_positions(tape: &mut Tape, points: &Value, triangles: &[[u32; 3]]) -> Value {
    tape.triple_extremes(points, triangles)
}

/// Computes `f_n = sum_{k in N(n)} MLP([r_{n,k} | f_n - f_k])`, Eq. (5); `r` is the difference of two positions.
///
/// # Shapes
/// - `positions`: n x 9, from [`triangle_positions`]
/// - `features`: n x n_in
/// - `graph`: n x n
/// - returns n x width
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::autodiff::{Tape, Value};
/// use neural_mesh::linalg::{Csr, Matrix};
/// use neural_mesh::model::{Affine, TriConv, tri_conv};
/// let value = |rows: usize, data: Vec<f32>| Value::constant(Matrix::new(rows, data.len() / rows, data));
/// // Looks at the feature only: MLP(d) = 2 ReLU(d + 1) + 10.
/// let mut first = vec![0.0; 10];
/// first[9] = 1.0;
/// let layer = TriConv {
///     hidden: Affine { weights: value(10, first), bias: value(1, vec![1.0]) },
///     output: Affine { weights: value(1, vec![2.0]), bias: value(1, vec![10.0]) },
/// };
/// let (positions, features) = (value(3, vec![0.0; 27]), value(3, vec![5.0, 3.0, 4.5]));
/// let star = Csr::from_edges(3, [[0, 1], [0, 2]]).into();
/// let f = tri_conv(&mut Tape::default(), &layer, &positions, features, &star);
/// // For triangle 0: 2 (3 + 1.5) + 2 * 10.
/// assert_eq!(f.matrix().data(), [29.0, 10.0, 11.0]);
/// ```
pub fn tri_conv(
    tape: &mut Tape,
    layer: &TriConv<Value>,
    positions: &Value,
    features: Value,
    graph: &Arc<Csr>,
) -> Value {
    let mapped = tape.concat_product(positions, &features, &layer.hidden.weights);
    drop(features);
    let output = [&layer.output.weights, &layer.output.bias];
    tape.pair_relu_product([&mapped, &layer.hidden.bias], graph, output)
}

#[derive(Clone, Copy)]
pub(super) struct Layers<'a> {
    pub tri_convs: &'a [TriConv<Value>],
    /// Map of the last features, from width to n_out.
    pub last: &'a Affine<Value>,
}

/// Applies consecutive layers like [`tri_conv`], and a linear map to the last features.
pub(super) fn tri_convs(tape: &mut Tape, net: Layers, positions: &Value, features: &Value, graph: &Arc<Csr>) -> Value {
    let Layers { tri_convs, last } = net;
    let Some((mut layer, later)) = tri_convs.split_first() else {
        return tape.affine(features, &last.weights, &last.bias);
    };
    let mut mapped = tape.concat_product(positions, features, &layer.hidden.weights);
    for next in later {
        let [on_positions, on_features] = halves(tape, &next.hidden.weights, positions.matrix().n_cols());
        let [weights, bias] = both_maps(tape, &layer.output, &on_features);
        let weights = tape.stack_rows(&on_positions, &weights);
        mapped = tape.concat_pair_relu_product(positions, [&mapped, &layer.hidden.bias], graph, [&weights, &bias]);
        layer = next;
    }
    let [weights, bias] = both_maps(tape, &layer.output, &last.weights);
    let result = tape.pair_relu_product([&mapped, &layer.hidden.bias], graph, [&weights, &bias]);
    tape.plus_row(&result, &last.bias)
}

fn halves(tape: &mut Tape, weights: &Value, n_first: usize) -> [Value; 2] {
    let (n_first, n_rows) = (n_first as u32, weights.matrix().n_rows() as u32);
    [0..n_first, n_first..n_rows].map(|rows| tape.gather(weights, &rows.collect::<Vec<_>>()))
}

fn both_maps(tape: &mut Tape, first: &Affine<Value>, second: &Value) -> [Value; 2] {
    [&first.weights, &first.bias].map(|rows| tape.product(rows, second))
}

impl TriConv<[usize; 2]> {
    pub(super) fn shape(n_in: usize, width: usize) -> Self {
        Self { hidden: Affine::shape(9 + n_in, width), output: Affine::shape(width, width) }
    }
}

impl<T> TriConv<T> {
    pub(super) fn try_map<U, E>(
        &self,
        name: &str,
        f: &mut impl FnMut(&str, &T) -> Result<U, E>,
    ) -> Result<TriConv<U>, E> {
        let hidden = self.hidden.try_map(&format!("{name}.hidden"), f)?;
        Ok(TriConv { hidden, output: self.output.try_map(&format!("{name}.output"), f)? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::Matrix;
    use crate::linalg::test_values::{assert_close, ragged_graph, random};

    #[test]
    fn layers_at_once_agree_with_one_after_the_other() {
        let (graph, tape) = (Arc::new(ragged_graph(40)), &mut Tape::default());
        let value = |n_rows, n_cols, seed| Value::constant(random(n_rows, n_cols, seed));
        let affine = |n_in, n_out, seed| Affine { weights: value(n_in, n_out, seed), bias: value(1, n_out, seed + 1) };
        let layer = |n_in: usize, seed| TriConv { hidden: affine(9 + n_in, 8, seed), output: affine(8, 8, seed + 2) };
        let (positions, prior, last) = (value(40, 9, 1), value(40, 1, 2), affine(8, 3, 20));
        for layers in [vec![], vec![layer(1, 3)], vec![layer(1, 3), layer(8, 7), layer(8, 11)]] {
            let features = layers.iter().fold(prior.clone(), |f, layer| tri_conv(tape, layer, &positions, f, &graph));
            let last = if layers.is_empty() { affine(1, 3, 20) } else { last.clone() };
            let expected = tape.affine(&features, &last.weights, &last.bias);
            let result = tri_convs(tape, Layers { tri_convs: &layers, last: &last }, &positions, &prior, &graph);
            // Tolerance relative to the largest value: cancelled sums keep the rounding of their terms.
            let largest = expected.matrix().data().iter().fold(0.0, |largest: f32, x| largest.max(x.abs()));
            let [result, expected] =
                [result, expected].map(|value| value.matrix().data().iter().map(|x| x / largest).collect::<Vec<_>>());
            assert_close(&result, &expected, 1e-5);
        }
    }

    #[test]
    fn agrees_with_the_equation_pair_by_pair() {
        let (positions, features, graph) = (random(40, 9, 1), random(40, 5, 2), Arc::new(ragged_graph(40)));
        let [w1, b1, w2, b2] = [random(14, 8, 3), random(1, 8, 4), random(8, 8, 5), random(1, 8, 6)];
        let affine = |w: &Matrix, b: &Matrix, x: &[f32]| -> Vec<f32> {
            let dot = |c: usize| x.iter().enumerate().map(|(k, x)| x * w.row(k)[c]).sum::<f32>();
            (0..w.n_cols()).map(|c| dot(c) + b.data()[c]).collect()
        };
        let row = |n: usize| [positions.row(n), features.row(n)].concat();
        let mut naive = vec![0.0; 40 * 8];
        for [n, k] in graph.entries() {
            let difference: Vec<f32> = row(n as usize).iter().zip(row(k as usize)).map(|(a, b)| a - b).collect();
            let hidden: Vec<f32> = affine(&w1, &b1, &difference).iter().map(|h| h.max(0.0)).collect();
            let sums = &mut naive[n as usize * 8..][..8];
            sums.iter_mut().zip(affine(&w2, &b2, &hidden)).for_each(|(sum, y)| *sum += y);
        }
        let [weights, bias, output_weights, output_bias] = [w1, b1, w2, b2].map(Value::constant);
        let layer =
            TriConv { hidden: Affine { weights, bias }, output: Affine { weights: output_weights, bias: output_bias } };
        let [positions, features] = [positions.clone(), features.clone()].map(Value::constant);
        let result = tri_conv(&mut Tape::default(), &layer, &positions, features, &graph);
        assert_close(result.matrix().data(), &naive, 1e-5);
    }
}
