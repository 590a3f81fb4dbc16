//! The sum over neighbours of `ReLU(u_n - u_k + bias)`: the hidden layer of TriConv, Eq. (5), factorised.
//!
//! The first layer acts on each triangle before the difference, and the last commutes with the sum.

use super::isa::{ColumnKernel, Isa, RowKernel, relu};
use super::matrix::window;
use super::product::{column_sums, multiply_rows};
use super::{Csr, Matrix};
use std::ops::Range;

/// Computes `y_n = sum_k max(u_n - u_k + bias, 0)` over the neighbours k.
///
/// # Shapes
/// - `u` and the result: n x width; `bias`: width
/// - `graph`: n x n
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::{Csr, Matrix, pair_relu};
/// let u = Matrix::new(3, 1, vec![1.0, 5.0, 7.0]);
/// let path = Csr::from_edges(3, [[0, 1], [1, 2]]);
/// assert_eq!(pair_relu(&u, &[1.0], &path).data(), [0.0, 5.0, 3.0]);
/// ```
pub fn pair_relu(u: &Matrix, bias: &[f32], graph: &Csr) -> Matrix {
    Isa::best().compute_matrix(&PairReluKernel::new(u, bias, graph), u.n_rows(), u.n_cols())
}

/// Computes `y w + m output_bias` for `y` of [`pair_relu`], where node n has m neighbours.
///
/// # Shapes
/// - `u`, `bias`, `graph`: as for [`pair_relu`]
/// - `weights`: width x n_out, `output_bias`: n_out
/// - returns n x n_out
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::{Csr, Matrix, pair_relu_product};
/// let u = Matrix::new(3, 1, vec![1.0, 5.0, 7.0]);
/// let path = Csr::from_edges(3, [[0, 1], [1, 2]]);
/// let weights = Matrix::new(1, 1, vec![10.0]);
/// assert_eq!(pair_relu_product(&u, &[1.0], &path, &weights, &[0.5]).data(), [0.5, 51.0, 30.5]);
/// ```
pub fn pair_relu_product(u: &Matrix, bias: &[f32], graph: &Csr, weights: &Matrix, output_bias: &[f32]) -> Matrix {
    PairReluProductKernel { left: None, sums: PairReluKernel::new(u, bias, graph), weights, output_bias }.product()
}

/// Computes [`pair_relu_product`] of `[x | y]` with additional columns x.
///
/// # Shapes
/// - `left`: x, n x n_left
/// - `weights`: (n_left + width) x n_out, `output_bias`: 1 x n_out
/// - returns n x n_out
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::{Csr, Matrix, concat_pair_relu_product};
/// let column = |x: &[f32]| Matrix::new(x.len(), 1, x.to_vec());
/// let path = Csr::from_edges(3, [[0, 1], [1, 2]]);
/// let (left, u, output_bias) = (column(&[1.0, 2.0, 3.0]), column(&[1.0, 5.0, 7.0]), column(&[0.5]));
/// let product = concat_pair_relu_product(&left, &u, &[1.0], &path, [&column(&[100.0, 10.0]), &output_bias]);
/// assert_eq!(product.data(), [100.5, 251.0, 330.5]);
/// ```
pub fn concat_pair_relu_product(
    left: &Matrix,
    u: &Matrix,
    bias: &[f32],
    graph: &Csr,
    [weights, output_bias]: [&Matrix; 2],
) -> Matrix {
    let (sums, output_bias) = (PairReluKernel::new(u, bias, graph), output_bias.data());
    PairReluProductKernel { left: Some(left), sums, weights, output_bias }.product()
}

/// The derivatives of [`pair_relu`].
#[derive(Clone, Debug, PartialEq)]
pub struct PairReluGradients {
    /// Derivative to `u`, n x width.
    pub u: Matrix,
    /// Derivative to the bias, 1 x width.
    pub bias: Matrix,
}

/// Computes the derivatives of [`pair_relu`]; a pair at exactly zero contributes none.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::{Csr, Matrix, pair_relu_backward};
/// let (u, gradient) = (Matrix::new(2, 1, vec![1.0, 5.0]), Matrix::new(2, 1, vec![10.0, 3.0]));
/// // Only the pair (1, 0) is active: max(5 - 1, 0).
/// let gradients = pair_relu_backward(&u, &[0.0], &Csr::from_edges(2, [[0, 1]]), &gradient);
/// assert_eq!((gradients.u.data(), gradients.bias.data()), ([-3.0, 3.0].as_slice(), [3.0].as_slice()));
/// ```
pub fn pair_relu_backward(u: &Matrix, bias: &[f32], graph: &Csr, gradient: &Matrix) -> PairReluGradients {
    assert_eq!(u.shape(), gradient.shape(), "one gradient per entry");
    let (isa, sums) = (Isa::best(), || PairReluKernel::new(u, bias, graph));
    let [n, width] = u.shape();
    let as_first = isa.compute_matrix(&FirstGradientKernel { sums: sums(), gradient }, n, width);
    let (incoming, _) = graph.transpose();
    let all = TotalGradientKernel { sums: sums(), incoming: &incoming, gradient, as_first: &as_first };
    PairReluGradients { u: isa.compute_matrix(&all, n, width), bias: column_sums(&as_first) }
}

struct PairReluKernel<'a> {
    u: &'a Matrix,
    bias: &'a [f32],
    graph: &'a Csr,
}

impl<'a> PairReluKernel<'a> {
    fn new(u: &'a Matrix, bias: &'a [f32], graph: &'a Csr) -> Self {
        assert_eq!([graph.n_rows(), graph.n_cols()], [u.n_rows(); 2], "one graph node per row");
        assert_eq!(bias.len(), u.n_cols(), "one bias per column");
        Self { u, bias, graph }
    }

    #[inline(always)]
    fn own<const COLS: usize>(&self, n: usize, col: usize) -> [f32; COLS] {
        let mut own = *self.u.window::<COLS>(n, col);
        own.iter_mut().zip(window::<COLS>(self.bias, col)).for_each(|(own, bias)| *own += bias);
        own
    }

    #[inline(always)]
    fn other<const COLS: usize>(&self, k: u32, col: usize) -> &[f32; COLS] {
        self.u.window(k as usize, col)
    }
}

impl ColumnKernel for PairReluKernel<'_> {
    fn width(&self) -> usize {
        self.u.n_cols()
    }

    #[inline(always)]
    fn columns<const COLS: usize, const FMA: bool>(&self, n: usize, col: usize, out: &mut [f32; COLS]) {
        let own = self.own::<COLS>(n, col);
        let mut sums = [0.0f32; COLS];
        // Four neighbours at once: a quarter of the loads and stores of the sums.
        let (groups, rest) = self.graph.row(n).as_chunks();
        for &[i, j, k, l] in groups {
            let [i, j, k, l] = [self.other::<COLS>(i, col), self.other(j, col), self.other(k, col), self.other(l, col)];
            for c in 0..COLS {
                sums[c] += (relu(own[c] - i[c]) + relu(own[c] - j[c])) + (relu(own[c] - k[c]) + relu(own[c] - l[c]));
            }
        }
        for &k in rest {
            let other = self.other::<COLS>(k, col);
            for c in 0..COLS {
                sums[c] += relu(own[c] - other[c]);
            }
        }
        *out = sums;
    }
}

struct PairReluProductKernel<'a> {
    left: Option<&'a Matrix>,
    sums: PairReluKernel<'a>,
    weights: &'a Matrix,
    output_bias: &'a [f32],
}

impl PairReluProductKernel<'_> {
    fn product(&self) -> Matrix {
        let (n_rows, [n_in, n_out]) = (self.sums.u.n_rows(), self.weights.shape());
        let n_left = self.left.map_or(0, Matrix::n_cols);
        assert!(self.left.is_none_or(|left| left.n_rows() == n_rows), "both matrices need equal numbers of rows");
        assert_eq!(n_left + self.sums.u.n_cols(), n_in, "weights need as many rows as left and u have columns");
        assert_eq!(self.output_bias.len(), n_out, "one output bias per column");
        Isa::best().compute_matrix(self, n_rows, n_out)
    }
}

impl RowKernel for PairReluProductKernel<'_> {
    #[inline(always)]
    fn compute<const FMA: bool>(&self, rows: Range<usize>, out: &mut [f32]) {
        let mut sums = vec![0.0; rows.len() * self.sums.width()];
        self.sums.compute::<FMA>(rows.clone(), &mut sums);
        if let Some(left) = self.left {
            sums = side_by_side(left, rows.clone(), &sums);
        }
        multiply_rows::<FMA>(&sums, self.weights, out);
        for (n, out) in rows.zip(out.chunks_exact_mut(self.output_bias.len().max(1))) {
            let n_neighbours = self.sums.graph.row(n).len() as f32;
            out.iter_mut().zip(self.output_bias).for_each(|(y, bias)| *y += n_neighbours * bias);
        }
    }
}

fn side_by_side(left: &Matrix, rows: Range<usize>, right: &[f32]) -> Vec<f32> {
    let width = right.len() / rows.len().max(1);
    let mut joined = Vec::with_capacity(right.len() + rows.len() * left.n_cols());
    for (row, right) in rows.zip(right.chunks_exact(width.max(1))) {
        joined.extend_from_slice(left.row(row));
        joined.extend_from_slice(right);
    }
    joined
}

struct FirstGradientKernel<'a> {
    sums: PairReluKernel<'a>,
    gradient: &'a Matrix,
}

impl ColumnKernel for FirstGradientKernel<'_> {
    fn width(&self) -> usize {
        self.sums.width()
    }

    #[inline(always)]
    fn columns<const COLS: usize, const FMA: bool>(&self, n: usize, col: usize, out: &mut [f32; COLS]) {
        let own = self.sums.own::<COLS>(n, col);
        let mut counts = [0.0f32; COLS];
        for &k in self.sums.graph.row(n) {
            let other = self.sums.other::<COLS>(k, col);
            for c in 0..COLS {
                counts[c] += if own[c] - other[c] > 0.0 { 1.0 } else { 0.0 };
            }
        }
        let gradient = self.gradient.window::<COLS>(n, col);
        for c in 0..COLS {
            out[c] = counts[c] * gradient[c];
        }
    }
}

/// The kernel of the gradient of `u_k`: its gradient as first row of pairs minus that as second.
struct TotalGradientKernel<'a> {
    sums: PairReluKernel<'a>,
    incoming: &'a Csr,
    gradient: &'a Matrix,
    as_first: &'a Matrix,
}

impl ColumnKernel for TotalGradientKernel<'_> {
    fn width(&self) -> usize {
        self.sums.width()
    }

    #[inline(always)]
    fn columns<const COLS: usize, const FMA: bool>(&self, k: usize, col: usize, out: &mut [f32; COLS]) {
        let bias = window::<COLS>(self.sums.bias, col);
        let other = self.sums.u.window::<COLS>(k, col);
        let mut as_second = [0.0f32; COLS];
        for &n in self.incoming.row(k) {
            let first = self.sums.other::<COLS>(n, col);
            let gradient = self.gradient.window::<COLS>(n as usize, col);
            for c in 0..COLS {
                as_second[c] += if first[c] + bias[c] - other[c] > 0.0 { gradient[c] } else { 0.0 };
            }
        }
        let as_first = self.as_first.window::<COLS>(k, col);
        for c in 0..COLS {
            out[c] = as_first[c] - as_second[c];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_values::{assert_close, assert_slopes, naive_product, ragged_graph, random};
    use super::*;

    fn naive(u: &Matrix, bias: &[f32], graph: &Csr) -> Matrix {
        Matrix::from_fn(u.n_rows(), u.n_cols(), |n, c| {
            graph.row(n).iter().map(|&k| (u.row(n)[c] - u.row(k as usize)[c] + bias[c]).max(0.0)).sum()
        })
    }

    #[test]
    fn every_instruction_set_agrees_with_the_pair_by_pair_form() {
        Isa::on_each(|| {
            for [n, width] in [[0, 4], [1, 3], [90, 64], [200, 37], [70, 128]] {
                let (u, bias, graph) = (random(n, width, 5), random(1, width, 6), ragged_graph(n));
                let expected = naive(&u, bias.data(), &graph);
                assert_close(pair_relu(&u, bias.data(), &graph).data(), expected.data(), 1e-5);
                let (weights, output_bias) = (random(width, 20, 7), random(1, 20, 8));
                let product = naive_product(&expected, &weights, &[]);
                let entry = |n: usize, c| product.row(n)[c] + graph.row(n).len() as f32 * output_bias.data()[c];
                let expected = Matrix::from_fn(n, 20, entry);
                let found = pair_relu_product(&u, bias.data(), &graph, &weights, output_bias.data());
                assert_close(found.data(), expected.data(), 1e-5);
                let (left, of_beside) = (random(n, 9, 9), random(9, 20, 10));
                let weights = Matrix::new(9 + width, 20, [of_beside.data(), weights.data()].concat());
                let further = naive_product(&left, &of_beside, &[]);
                let expected = Matrix::from_fn(n, 20, |n, c| expected.row(n)[c] + further.row(n)[c]);
                let found = concat_pair_relu_product(&left, &u, bias.data(), &graph, [&weights, &output_bias]);
                assert_close(found.data(), expected.data(), 1e-5);
            }
        });
    }

    fn naive_backward(u: &Matrix, bias: &[f32], graph: &Csr, gradient: &Matrix) -> [Matrix; 2] {
        let width = u.n_cols();
        let (mut to_u, mut to_bias) = (Matrix::zeros(u.n_rows(), width), Matrix::zeros(1, width));
        for [n, k] in graph.entries().map(|pair| pair.map(|row| row as usize)) {
            for c in (0..width).filter(|&c| u.row(n)[c] + bias[c] - u.row(k)[c] > 0.0) {
                to_u.data_mut()[n * width + c] += gradient.row(n)[c];
                to_u.data_mut()[k * width + c] -= gradient.row(n)[c];
                to_bias.data_mut()[c] += gradient.row(n)[c];
            }
        }
        [to_u, to_bias]
    }

    #[test]
    fn every_instruction_set_agrees_with_the_naive_derivative_also_at_kinks() {
        Isa::on_each(|| {
            for [n, width] in [[0, 4], [1, 3], [90, 64], [300, 37]] {
                let (u, bias, graph) = (random(n, width, 5), random(1, width, 6), ragged_graph(n));
                let gradient = random(n, width, 7);
                // Few values, so that many pairs are at zero.
                let coarse = Matrix::from_fn(n, width, |i, c| (u.row(i)[c] * 2.0).round());
                for (u, bias) in [(u, bias.data().to_vec()), (coarse, vec![1.0; width])] {
                    let [to_u, to_bias] = naive_backward(&u, &bias, &graph, &gradient);
                    let found = pair_relu_backward(&u, &bias, &graph, &gradient);
                    assert_close(found.u.data(), to_u.data(), 1e-5);
                    assert_close(found.bias.data(), to_bias.data(), 1e-4);
                }
            }
        });
    }

    #[test]
    fn gradients_are_slopes_in_double_precision() {
        let (u, bias, graph, gradient) = (random(25, 3, 5), random(1, 3, 6), ragged_graph(25), random(25, 3, 7));
        let found = pair_relu_backward(&u, bias.data(), &graph, &gradient);
        let inputs = [u.data(), bias.data()].concat();
        assert_slopes(&[found.u.data(), found.bias.data()].concat(), &inputs, |x| {
            let pairs = graph.entries().flat_map(|pair| [0, 1, 2].map(|c| (pair.map(|row| row as usize), c)));
            let value = |([n, k], c): ([usize; 2], usize)| {
                f64::from(gradient.row(n)[c]) * (x[n * 3 + c] - x[k * 3 + c] + x[75 + c]).max(0.0)
            };
            pairs.map(value).sum()
        });
    }
}
