//! The product of features and weights.

use super::Matrix;
use super::isa::{Isa, NARROW, RowKernel, multiply_add};
use super::matrix::window;
use std::ops::Range;

/// Computes `x w + bias`.
///
/// # Shapes
/// - `x`: n x n_in; `weights`: n_in x n_out
/// - `bias`: n_out, or empty
/// - returns n x n_out
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::{Matrix, product};
/// let x = Matrix::new(1, 2, vec![1.0, 2.0]);
/// let w = Matrix::new(2, 2, vec![1.0, 0.0, 10.0, 1.0]);
/// assert_eq!(product(&x, &w, &[0.5, 0.0]).data(), [21.5, 2.0]);
/// ```
pub fn product(x: &Matrix, weights: &Matrix, bias: &[f32]) -> Matrix {
    assert_eq!(x.n_cols(), weights.n_rows(), "weights need as many rows as x has columns");
    assert!(bias.is_empty() || bias.len() == weights.n_cols(), "one bias per column");
    Isa::best().compute_matrix(&Product { x, weights, bias }, x.n_rows(), weights.n_cols())
}

/// Computes `[a | b] w` without storing the joined matrix.
///
/// # Shapes
/// - `a`: n x n_a, `b`: n x n_b
/// - `weights`: (n_a + n_b) x n_out
/// - returns n x n_out
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::{Matrix, concat_product};
/// let column = |x: f32, y: f32| Matrix::new(2, 1, vec![x, y]);
/// assert_eq!(concat_product(&column(1.0, 2.0), &column(3.0, 4.0), &column(10.0, 1.0)).data(), [13.0, 24.0]);
/// ```
pub fn concat_product(a: &Matrix, b: &Matrix, weights: &Matrix) -> Matrix {
    assert_eq!(a.n_rows(), b.n_rows(), "both matrices need equal numbers of rows");
    assert_eq!(a.n_cols() + b.n_cols(), weights.n_rows(), "weights need as many rows as both matrices have columns");
    Isa::best().compute_matrix(&ConcatProduct { a, b, weights }, a.n_rows(), weights.n_cols())
}

/// Computes the derivative of `x w` to `x`, n x n_in.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::{Matrix, product_input_backward};
/// let (gradient, weights) = (Matrix::new(1, 1, vec![2.0]), Matrix::new(2, 1, vec![3.0, 4.0]));
/// assert_eq!(product_input_backward(&gradient, &weights).data(), [6.0, 8.0]);
/// ```
pub fn product_input_backward(gradient: &Matrix, weights: &Matrix) -> Matrix {
    product(gradient, &weights.transpose(), &[])
}

/// Computes the derivative of `x w` to `w`, n_in x n_out.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::{Matrix, product_weights_backward};
/// let (x, gradient) = (Matrix::new(2, 1, vec![3.0, 4.0]), Matrix::new(2, 1, vec![1.0, 10.0]));
/// assert_eq!(product_weights_backward(&x, &gradient).data(), [43.0]);
/// ```
pub fn product_weights_backward(x: &Matrix, gradient: &Matrix) -> Matrix {
    assert_eq!(x.n_rows(), gradient.n_rows(), "the gradient needs as many rows as x");
    let [n_in, n_out] = [x.n_cols(), gradient.n_cols()];
    let n_parts = x.n_rows().div_ceil(ROWS_PER_SUM);
    let parts = Isa::best().compute_matrix(&WeightsBackward { x, gradient }, n_parts, n_in * n_out);
    let mut sum = vec![0.0; n_in * n_out];
    for part in 0..parts.n_rows() {
        sum.iter_mut().zip(parts.row(part)).for_each(|(s, p)| *s += p);
    }
    Matrix::new(n_in, n_out, sum)
}

#[doc(hidden)]
pub fn column_sums(m: &Matrix) -> Matrix {
    product_weights_backward(&Matrix::new(m.n_rows(), 1, vec![1.0; m.n_rows()]), m)
}

struct Product<'a> {
    x: &'a Matrix,
    weights: &'a Matrix,
    bias: &'a [f32],
}

impl RowKernel for Product<'_> {
    #[inline(always)]
    fn compute<const FMA: bool>(&self, rows: Range<usize>, out: &mut [f32]) {
        let n_in = self.weights.n_rows();
        multiply_rows::<FMA>(&self.x.data()[rows.start * n_in..rows.end * n_in], self.weights, out);
        add_bias(out, self.bias);
    }
}

#[inline(always)]
pub(super) fn add_bias(rows: &mut [f32], bias: &[f32]) {
    for row in rows.chunks_exact_mut(bias.len().max(1)) {
        row.iter_mut().zip(bias).for_each(|(y, bias)| *y += bias);
    }
}

struct ConcatProduct<'a> {
    a: &'a Matrix,
    b: &'a Matrix,
    weights: &'a Matrix,
}

impl RowKernel for ConcatProduct<'_> {
    #[inline(always)]
    fn compute<const FMA: bool>(&self, rows: Range<usize>, out: &mut [f32]) {
        let mut joined = Vec::with_capacity(rows.len() * self.weights.n_rows());
        for row in rows {
            joined.extend_from_slice(self.a.row(row));
            joined.extend_from_slice(self.b.row(row));
        }
        multiply_rows::<FMA>(&joined, self.weights, out);
    }
}

#[inline(always)]
pub(super) fn multiply_rows<const FMA: bool>(rows: &[f32], weights: &Matrix, out: &mut [f32]) {
    let [n_in, n_out] = weights.shape();
    if n_out == 1 {
        return dots::<FMA>(rows, weights.data(), out);
    }
    multiply::<FMA>(rows, [n_in, n_out], weights.data(), out);
}

#[inline(always)]
fn dots<const FMA: bool>(rows: &[f32], column: &[f32], out: &mut [f32]) {
    let (narrow, rest) = column.as_chunks::<NARROW>();
    for (row, out) in rows.chunks_exact(column.len().max(1)).zip(out) {
        let (row_narrow, row_rest) = row.as_chunks::<NARROW>();
        let mut sums = [0.0f32; NARROW];
        for (a, b) in row_narrow.iter().zip(narrow) {
            for c in 0..NARROW {
                sums[c] = multiply_add::<FMA>(a[c], b[c], sums[c]);
            }
        }
        let mut n = NARROW;
        while n > 1 {
            n /= 2;
            for c in 0..n {
                sums[c] += sums[c + n];
            }
        }
        *out = row_rest.iter().zip(rest).fold(sums[0], |sum, (&a, &b)| multiply_add::<FMA>(a, b, sum));
    }
}

const ROWS_PER_SUM: usize = 256;

struct WeightsBackward<'a> {
    x: &'a Matrix,
    gradient: &'a Matrix,
}

impl RowKernel for WeightsBackward<'_> {
    #[inline(always)]
    fn compute<const FMA: bool>(&self, parts: Range<usize>, out: &mut [f32]) {
        let [n_in, n_out] = [self.x.n_cols(), self.gradient.n_cols()];
        for (part, out) in parts.zip(out.chunks_exact_mut((n_in * n_out).max(1))) {
            let rows = part * ROWS_PER_SUM..((part + 1) * ROWS_PER_SUM).min(self.x.n_rows());
            let x = &self.x.data()[rows.start * n_in..rows.end * n_in];
            let gradient = &self.gradient.data()[rows.start * n_out..rows.end * n_out];
            multiply::<FMA>(&transpose(x, n_in), [rows.len(), n_out], gradient, out);
        }
    }
}

#[inline(always)]
fn transpose(rows: &[f32], n_in: usize) -> Vec<f32> {
    (0..n_in).flat_map(|col| rows.iter().skip(col).step_by(n_in)).copied().collect()
}

/// Rows of a tile; with [`NARROW`] columns the sums fill twelve of AVX2's sixteen registers.
const TILE: usize = 6;

#[inline(always)]
fn multiply<const FMA: bool>(left: &[f32], shape: [usize; 2], right: &[f32], out: &mut [f32]) {
    let [n_inner, n_out] = shape;
    if left.is_empty() || n_inner == 0 {
        return;
    }
    let n_narrow = n_out - n_out % NARROW;
    for col in (0..n_narrow).step_by(NARROW) {
        columns::<FMA, NARROW>(left, shape, &right[col..], &mut out[col..]);
    }
    for col in n_narrow..n_out {
        columns::<FMA, 1>(left, shape, &right[col..], &mut out[col..]);
    }
}

/// Computes all rows of COLS columns, so that this strip of `right` stays in the caches.
#[inline(always)]
fn columns<const FMA: bool, const COLS: usize>(left: &[f32], shape: [usize; 2], right: &[f32], out: &mut [f32]) {
    let n = left.len() / shape[0];
    let (n_tiled, n_paired) = (n - n % TILE, n - n % TILE % 2);
    for row in (0..n_tiled).step_by(TILE) {
        tile::<FMA, TILE, COLS>(row, left, shape, right, out);
    }
    for row in (n_tiled..n_paired).step_by(2) {
        tile::<FMA, 2, COLS>(row, left, shape, right, out);
    }
    for row in n_paired..n {
        tile::<FMA, 1, COLS>(row, left, shape, right, out);
    }
}

#[inline(always)]
fn tile<const FMA: bool, const ROWS: usize, const COLS: usize>(
    first: usize,
    left: &[f32],
    [n_inner, n_out]: [usize; 2],
    right: &[f32],
    out: &mut [f32],
) {
    // Slices as long as the loop, so that no access is checked.
    let rows: [&[f32]; ROWS] = std::array::from_fn(|row| &left[(first + row) * n_inner..][..n_inner]);
    let mut sums = [[0.0f32; COLS]; ROWS];
    for k in 0..n_inner {
        let right = *window::<COLS>(right, k * n_out);
        for (sums, row) in sums.iter_mut().zip(rows) {
            let factor = row[k];
            for (sum, right) in sums.iter_mut().zip(right) {
                *sum = multiply_add::<FMA>(factor, right, *sum);
            }
        }
    }
    for (row, sums) in sums.iter().enumerate() {
        out[(first + row) * n_out..][..COLS].copy_from_slice(sums);
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_values::{assert_close, assert_slopes, naive_product, random};
    use super::*;

    #[test]
    fn every_instruction_set_agrees_with_the_naive_product() {
        Isa::on_each(|| {
            for [n, n_in, n_out] in
                [[0, 3, 4], [1, 1, 1], [7, 3, 64], [131, 64, 33], [70, 73, 128], [20, 64, 1], [5, 0, 3]]
            {
                let (x, w, b) = (random(n, n_in, 1), random(n_in, n_out, 2), random(1, n_out, 3));
                let expected = naive_product(&x, &w, b.data());
                assert_close(product(&x, &w, b.data()).data(), expected.data(), 1e-5);
            }
        });
    }

    #[test]
    fn a_product_of_two_parts_is_that_of_both_side_by_side() {
        Isa::on_each(|| {
            let (a, b, w) = (random(131, 9, 1), random(131, 64, 2), random(73, 40, 3));
            let joined =
                Matrix::from_fn(131, 73, |row, col| if col < 9 { a.row(row)[col] } else { b.row(row)[col - 9] });
            assert_close(concat_product(&a, &b, &w).data(), naive_product(&joined, &w, &[]).data(), 1e-5);
        });
    }

    #[test]
    fn derivatives_are_products_with_transposes() {
        Isa::on_each(|| {
            let (x, w, g) = (random(600, 9, 1), random(9, 37, 2), random(600, 37, 3));
            let to_weights = naive_product(&x.transpose(), &g, &[]);
            assert_close(product_weights_backward(&x, &g).data(), to_weights.data(), 1e-4);
            assert_close(product_input_backward(&g, &w).data(), naive_product(&g, &w.transpose(), &[]).data(), 1e-5);
        });
    }

    #[test]
    fn gradients_are_slopes_in_double_precision() {
        let (x, w, g) = (random(7, 5, 1), random(5, 3, 2), random(7, 3, 3));
        let gradients = [product_input_backward(&g, &w), product_weights_backward(&x, &g)];
        let gradients = gradients.map(Matrix::into_data).concat();
        assert_slopes(&gradients, &[x.data(), w.data()].concat(), |v| {
            let entry = |i: usize, c: usize| (0..5).map(|k| v[i * 5 + k] * v[35 + k * 3 + c]).sum::<f64>();
            (0..7).flat_map(|i| [0, 1, 2].map(|c| f64::from(g.row(i)[c]) * entry(i, c))).sum()
        });
    }
}
