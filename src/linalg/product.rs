//! The product of a matrix of features with a matrix of weights, and its derivatives.
//!
//! One register tile serves all three products: forward, to the input and to the weights.

use super::Matrix;
use super::isa::{Isa, RowKernel, fused};
use std::ops::Range;

/// Computes `x w + bias`.
///
/// # Shapes
/// - `x`: n x n_in
/// - `weights`: n_in x n_out, one row per input
/// - `bias`: n_out, or empty for none
/// - returns n x n_out
///
/// # Panics
/// When the shapes do not match.
///
/// ```
/// use neural_mesh::linalg::{Matrix, product};
/// let x = Matrix::new(1, 2, vec![1.0, 2.0]);
/// let w = Matrix::new(2, 2, vec![1.0, 0.0, 10.0, 1.0]);
/// assert_eq!(product(&x, &w, &[0.5, 0.0]).data(), [21.5, 2.0]);
/// ```
pub fn product(x: &Matrix, weights: &Matrix, bias: &[f32]) -> Matrix {
    product_on(Isa::best(), x, weights, bias, false)
}

/// Computes `max(x w + bias, 0)`; shapes as in [`product`].
///
/// # Panics
/// When the shapes do not match.
///
/// ```
/// use neural_mesh::linalg::{Matrix, product_relu};
/// let x = Matrix::new(1, 1, vec![1.0]);
/// assert_eq!(product_relu(&x, &Matrix::new(1, 2, vec![3.0, -3.0]), &[]).data(), [3.0, 0.0]);
/// ```
pub fn product_relu(x: &Matrix, weights: &Matrix, bias: &[f32]) -> Matrix {
    product_on(Isa::best(), x, weights, bias, true)
}

/// Derivative of `x w` to `x`: `gradient` times the transposed weights, n x n_in.
///
/// # Panics
/// When the shapes do not match.
pub fn product_input_backward(gradient: &Matrix, weights: &Matrix) -> Matrix {
    product(gradient, &weights.transposed(), &[])
}

/// Derivative of `x w` to `w`: the transposed `x` times `gradient`, n_in x n_out.
///
/// # Panics
/// When the shapes do not match.
pub fn product_weights_backward(x: &Matrix, gradient: &Matrix) -> Matrix {
    weights_backward_on(Isa::best(), x, gradient)
}

fn product_on(isa: Isa, x: &Matrix, weights: &Matrix, bias: &[f32], relu: bool) -> Matrix {
    assert_eq!(x.n_cols(), weights.n_rows(), "columns of x and rows of weights");
    assert!(bias.is_empty() || bias.len() == weights.n_cols(), "one bias per column");
    isa.matrix(&Product { x, weights, bias, relu }, x.n_rows(), weights.n_cols())
}

fn weights_backward_on(isa: Isa, x: &Matrix, gradient: &Matrix) -> Matrix {
    assert_eq!(x.n_rows(), gradient.n_rows(), "rows of x and of the gradient");
    let [n_in, n_out] = [x.n_cols(), gradient.n_cols()];
    let parts = isa.matrix(&WeightsBackward { x, gradient }, x.n_rows().div_ceil(PART), n_in * n_out);
    let mut sum = vec![0.0; n_in * n_out];
    for part in 0..parts.n_rows() {
        sum.iter_mut().zip(parts.row(part)).for_each(|(s, p)| *s += p);
    }
    Matrix::new(n_in, n_out, sum)
}

struct Product<'a> {
    x: &'a Matrix,
    weights: &'a Matrix,
    bias: &'a [f32],
    relu: bool,
}

impl RowKernel for Product<'_> {
    #[inline(always)]
    fn compute<const LANES: usize, const FMA: bool>(&self, rows: Range<usize>, out: &mut [f32]) {
        let [n_in, n_out] = self.weights.shape();
        let x = &self.x.data()[rows.start * n_in..rows.end * n_in];
        let left = Strided { data: x, row_step: n_in, inner_step: 1 };
        multiply::<LANES, FMA>(left, [rows.len(), n_in, n_out], self.weights.data(), out);
        for row in out.chunks_exact_mut(n_out.max(1)) {
            if !self.bias.is_empty() {
                row.iter_mut().zip(self.bias).for_each(|(y, b)| *y += b);
            }
            if self.relu {
                row.iter_mut().for_each(|y| *y = y.max(0.0));
            }
        }
    }
}

/// Rows summed per part; the parts are then added in order.
const PART: usize = 1024;

struct WeightsBackward<'a> {
    x: &'a Matrix,
    gradient: &'a Matrix,
}

impl RowKernel for WeightsBackward<'_> {
    #[inline(always)]
    fn compute<const LANES: usize, const FMA: bool>(&self, parts: Range<usize>, out: &mut [f32]) {
        let [n_in, n_out] = [self.x.n_cols(), self.gradient.n_cols()];
        for (part, out) in parts.zip(out.chunks_exact_mut((n_in * n_out).max(1))) {
            let rows = part * PART..((part + 1) * PART).min(self.x.n_rows());
            let x = &self.x.data()[rows.start * n_in..rows.end * n_in];
            let gradient = &self.gradient.data()[rows.start * n_out..rows.end * n_out];
            let left = Strided { data: x, row_step: 1, inner_step: n_in };
            multiply::<LANES, FMA>(left, [n_in, rows.len(), n_out], gradient, out);
        }
    }
}

/// A left factor whose entry (row, k) is `data[row * row_step + k * inner_step]`.
#[derive(Clone, Copy)]
struct Strided<'a> {
    data: &'a [f32],
    row_step: usize,
    inner_step: usize,
}

impl<'a> Strided<'a> {
    #[inline(always)]
    fn from_row(self, row: usize) -> Self {
        Self { data: &self.data[row * self.row_step..], ..self }
    }
}

/// Rows of a register tile: with two vectors per row, twelve accumulators, which fit 16 registers.
const TILE_ROWS: usize = 6;

#[inline(always)]
fn multiply<const LANES: usize, const FMA: bool>(
    left: Strided,
    [n, n_inner, n_out]: [usize; 3],
    right: &[f32],
    out: &mut [f32],
) {
    if n_inner == 0 {
        return;
    }
    let mut row = 0;
    while row + TILE_ROWS <= n {
        tile_row::<LANES, FMA, TILE_ROWS>(left.from_row(row), [n_inner, n_out], right, &mut out[row * n_out..]);
        row += TILE_ROWS;
    }
    for row in row..n {
        tile_row::<LANES, FMA, 1>(left.from_row(row), [n_inner, n_out], right, &mut out[row * n_out..]);
    }
}

#[inline(always)]
fn tile_row<const LANES: usize, const FMA: bool, const ROWS: usize>(
    left: Strided,
    [n_inner, n_out]: [usize; 2],
    right: &[f32],
    out: &mut [f32],
) {
    let mut col = 0;
    while col + 2 * LANES <= n_out {
        tile::<LANES, FMA, ROWS, 2>(left, [n_inner, n_out], &right[col..], &mut out[col..]);
        col += 2 * LANES;
    }
    while col + LANES <= n_out {
        tile::<LANES, FMA, ROWS, 1>(left, [n_inner, n_out], &right[col..], &mut out[col..]);
        col += LANES;
    }
    for col in col..n_out {
        tile::<1, FMA, ROWS, 1>(left, [n_inner, n_out], &right[col..], &mut out[col..]);
    }
}

/// ROWS x (VECTORS * LANES) entries of the product at the head of `out`.
#[inline(always)]
fn tile<const LANES: usize, const FMA: bool, const ROWS: usize, const VECTORS: usize>(
    left: Strided,
    [n_inner, n_out]: [usize; 2],
    right: &[f32],
    out: &mut [f32],
) {
    let mut sums = [[[0.0f32; LANES]; VECTORS]; ROWS];
    for k in 0..n_inner {
        let right = &right[k * n_out..][..VECTORS * LANES];
        for (row, sums) in sums.iter_mut().enumerate() {
            let factor = left.data[row * left.row_step + k * left.inner_step];
            for (sums, right) in sums.iter_mut().zip(right.chunks_exact(LANES)) {
                for (sum, right) in sums.iter_mut().zip(right) {
                    *sum = fused::<FMA>(factor, *right, *sum);
                }
            }
        }
    }
    for (row, sums) in sums.iter().enumerate() {
        out[row * n_out..][..VECTORS * LANES].copy_from_slice(sums.as_flattened());
    }
}

#[cfg(test)]
mod tests {
    use super::super::matrix::test_values::{assert_close, random};
    use super::*;

    fn naive(x: &Matrix, weights: &Matrix, bias: &[f32]) -> Matrix {
        Matrix::from_fn(x.n_rows(), weights.n_cols(), |i, c| {
            let dot: f32 = (0..x.n_cols()).map(|k| x.row(i)[k] * weights.row(k)[c]).sum();
            dot + bias.get(c).unwrap_or(&0.0)
        })
    }

    #[test]
    fn every_instruction_set_agrees_with_the_naive_product() {
        for isa in Isa::available() {
            for [n, n_in, n_out] in
                [[0, 3, 4], [1, 1, 1], [7, 3, 64], [131, 64, 33], [70, 73, 128], [20, 64, 1], [5, 0, 3]]
            {
                let (x, w, b) = (random(n, n_in, 1), random(n_in, n_out, 2), random(1, n_out, 3));
                let expected = naive(&x, &w, b.data());
                assert_close(product_on(isa, &x, &w, b.data(), false).data(), expected.data(), 1e-5);
                let clamped: Vec<f32> = expected.data().iter().map(|y| y.max(0.0)).collect();
                assert_close(product_on(isa, &x, &w, b.data(), true).data(), &clamped, 1e-5);
            }
        }
    }

    #[test]
    fn derivatives_are_products_with_transposes() {
        for isa in Isa::available() {
            let (x, w, g) = (random(2500, 9, 1), random(9, 37, 2), random(2500, 37, 3));
            let to_weights = naive(&x.transposed(), &g, &[]);
            assert_close(weights_backward_on(isa, &x, &g).data(), to_weights.data(), 1e-4);
            assert_close(product_input_backward(&g, &w).data(), naive(&g, &w.transposed(), &[]).data(), 1e-5);
        }
    }
}
