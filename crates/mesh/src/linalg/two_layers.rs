//! Two affine maps with a ReLU between them.

use super::Matrix;
use super::group_layers::apply_layers;
use super::isa::{Isa, RowKernel};
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
    let [n_hidden, n_out] = second[0].shape();
    assert_eq!(first[0].shape(), [x.n_cols(), n_hidden], "sizes of x and of the layers must match");
    assert_eq!([first[1].shape(), second[1].shape()], [[1, n_hidden], [1, n_out]], "one bias per column");
    Isa::best().compute_matrix(&TwoLayers { x, first, second }, x.n_rows(), n_out)
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
        let rows = &self.x.data()[rows.start * n_in..rows.end * n_in];
        apply_layers::<FMA>(rows, &[], &[self.first, self.second], out);
    }
}

#[cfg(test)]
mod tests {
    use super::super::product;
    use super::super::test_values::{assert_close, random};
    use super::*;

    #[test]
    fn every_instruction_set_agrees_with_one_layer_after_the_other() {
        Isa::on_each(|| {
            for [n, n_in, n_hidden, n_out] in [[0, 3, 4, 1], [131, 16, 16, 1], [70, 5, 37, 1], [90, 20, 9, 33]] {
                let (x, w, b) = (random(n, n_in, 1), random(n_in, n_hidden, 2), random(1, n_hidden, 3));
                let [second, bias] = [random(n_hidden, n_out, 4), random(1, n_out, 5)];
                let mut hidden = product(&x, &w, b.data());
                hidden.data_mut().iter_mut().for_each(|y| *y = y.max(0.0));
                let expected = product(&hidden, &second, bias.data());
                assert_close(two_layers(&x, [&w, &b], [&second, &bias]).data(), expected.data(), 1e-5);
            }
        });
    }
}
