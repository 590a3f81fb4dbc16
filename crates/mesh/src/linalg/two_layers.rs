//! Two affine maps with a ReLU between them.

use super::Matrix;
use super::isa::{Isa, RowKernel, relu};
use super::product::{add_bias, multiply_rows};
use std::ops::Range;

/// Computes `max(x w + b, 0) w' + b'`.
///
/// # Shapes
/// - `x`: n x n_in
/// - `first`: `[weights, bias]`, n_in x n_hidden and 1 x n_hidden
/// - `second`: `[weights, bias]`, n_hidden x n_out and 1 x n_out
/// - returns n x n_out
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::{Matrix, two_layers};
/// let number = |x: f32| Matrix::new(1, 1, vec![x]);
/// let x = Matrix::new(2, 1, vec![1.0, -1.0]);
/// assert_eq!(two_layers(&x, [&number(2.0), &number(1.0)], [&number(10.0), &number(5.0)]).data(), [35.0, 5.0]);
/// ```
pub fn two_layers(x: &Matrix, first: [&Matrix; 2], second: [&Matrix; 2]) -> Matrix {
    two_layers_on(Isa::best(), x, first, second)
}

fn two_layers_on(isa: Isa, x: &Matrix, first: [&Matrix; 2], second: [&Matrix; 2]) -> Matrix {
    let [n_hidden, n_out] = second[0].shape();
    assert_eq!(first[0].shape(), [x.n_cols(), n_hidden], "sizes of x and of the layers must match");
    assert_eq!([first[1].shape(), second[1].shape()], [[1, n_hidden], [1, n_out]], "one bias per column");
    isa.compute_matrix(&TwoLayers { x, first, second }, x.n_rows(), n_out)
}

struct TwoLayers<'a> {
    x: &'a Matrix,
    first: [&'a Matrix; 2],
    second: [&'a Matrix; 2],
}

impl RowKernel for TwoLayers<'_> {
    #[inline(always)]
    fn compute<const FMA: bool>(&self, rows: Range<usize>, out: &mut [f32]) {
        let n_in = self.x.n_cols();
        layers::<FMA>(&self.x.data()[rows.start * n_in..rows.end * n_in], self.first, self.second, out);
    }
}

#[inline(always)]
pub(super) fn layers<const FMA: bool>(rows: &[f32], first: [&Matrix; 2], second: [&Matrix; 2], out: &mut [f32]) {
    let [n_in, n_hidden] = first[0].shape();
    let mut hidden = vec![0.0; rows.len() / n_in.max(1) * n_hidden];
    multiply_rows::<FMA>(rows, first[0], &mut hidden);
    add_bias(&mut hidden, first[1].data());
    hidden.iter_mut().for_each(|y| *y = relu(*y));
    multiply_rows::<FMA>(&hidden, second[0], out);
    add_bias(out, second[1].data());
}

#[cfg(test)]
mod tests {
    use super::super::product;
    use super::super::test_values::{assert_close, random};
    use super::*;

    #[test]
    fn every_instruction_set_agrees_with_one_layer_after_the_other() {
        for isa in Isa::available() {
            for [n, n_in, n_hidden, n_out] in [[0, 3, 4, 1], [131, 16, 16, 1], [70, 5, 37, 1], [90, 20, 9, 33]] {
                let (x, w, b) = (random(n, n_in, 1), random(n_in, n_hidden, 2), random(1, n_hidden, 3));
                let [second, bias] = [random(n_hidden, n_out, 4), random(1, n_out, 5)];
                let mut hidden = product(&x, &w, b.data());
                hidden.data_mut().iter_mut().for_each(|y| *y = y.max(0.0));
                let expected = product(&hidden, &second, bias.data());
                assert_close(two_layers_on(isa, &x, [&w, &b], [&second, &bias]).data(), expected.data(), 1e-5);
            }
        }
    }
}
