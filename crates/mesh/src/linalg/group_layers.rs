//! Several layers applied group by group.

use super::Matrix;
use super::isa::{Isa, RowKernel, relu};
use super::product::{add_bias, multiply_rows};
use std::ops::Range;

/// Applies affine maps with ReLUs between them, then takes column maxima over groups of `group` rows.
///
/// # Shapes
/// - `x`: (n_groups * group) x n_in
/// - `layers`: `[weights, bias]`, n_before x n_after and 1 x n_after
/// - returns n_groups x n_out
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::{Matrix, layers_group_max};
/// let (x, one, zero) = (Matrix::new(2, 1, vec![-1.0, 3.0]), Matrix::new(1, 1, vec![1.0]), Matrix::zeros(1, 1));
/// assert_eq!(layers_group_max(&x, &[[&one, &zero], [&one, &one]], 2).data(), [4.0]);
/// ```
pub fn layers_group_max(x: &Matrix, layers: &[[&Matrix; 2]], group: usize) -> Matrix {
    let [n_groups, n_out] = check_shapes(x, layers, group);
    Isa::best().compute_matrix(&PooledLayersKernel { x, layers, group }, n_groups, n_out)
}

/// Applies affine maps with ReLUs between them, adding each group's row of `group_rows` after the first map; the last
/// gives one column.
///
/// # Shapes
/// - `x`: (n_groups * group) x n_in; `group_rows`: n_groups x n_first
/// - returns (n_groups * group) x 1
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::{Matrix, layers_with_group_rows};
/// let (x, one, zero) = (Matrix::new(2, 1, vec![-1.0, 3.0]), Matrix::new(1, 1, vec![1.0]), Matrix::zeros(1, 1));
/// let found = layers_with_group_rows(&x, &Matrix::new(1, 1, vec![2.0]), &[[&one, &zero], [&one, &zero]], 2);
/// assert_eq!(found.data(), [1.0, 5.0]);
/// ```
pub fn layers_with_group_rows(x: &Matrix, group_rows: &Matrix, layers: &[[&Matrix; 2]], group: usize) -> Matrix {
    let [n_groups, n_out] = check_shapes(x, layers, group);
    assert_eq!(
        [n_out, n_groups, layers[0][0].n_cols()],
        [1, group_rows.n_rows(), group_rows.n_cols()],
        "a row per group"
    );
    let scores = Isa::best().compute_matrix(&GroupScoresKernel { x, group_rows, layers, group }, n_groups, group);
    Matrix::new(x.n_rows(), 1, scores.into_data())
}

fn check_shapes(x: &Matrix, layers: &[[&Matrix; 2]], group: usize) -> [usize; 2] {
    assert!(group > 0 && x.n_rows().is_multiple_of(group), "a whole number of groups of rows");
    let n_out = layers.iter().fold(x.n_cols(), |n_in, [weights, bias]| {
        assert_eq!(
            [weights.n_rows(), bias.data().len()],
            [n_in, weights.n_cols()],
            "sizes of consecutive layers must match"
        );
        weights.n_cols()
    });
    [x.n_rows() / group, n_out]
}

/// Applies affine maps with ReLUs between them, adding `group_row` after the first map.
#[inline(always)]
pub(super) fn apply_layers<const FMA: bool>(rows: &[f32], group_row: &[f32], layers: &[[&Matrix; 2]], out: &mut [f32]) {
    let n_rows = rows.len() / layers[0][0].n_rows().max(1);
    let mut now = Vec::new();
    for (i, [weights, bias]) in layers.iter().enumerate() {
        let is_last = i + 1 == layers.len();
        let mut hidden = vec![0.0; if is_last { 0 } else { n_rows * weights.n_cols() }];
        let next = if is_last { &mut *out } else { &mut hidden };
        multiply_rows::<FMA>(if i == 0 { rows } else { &now }, weights, next);
        add_bias(next, bias.data());
        if i == 0 {
            add_bias(next, group_row);
        }
        hidden.iter_mut().for_each(|y| *y = relu(*y));
        now = hidden;
    }
}

struct PooledLayersKernel<'a> {
    x: &'a Matrix,
    layers: &'a [[&'a Matrix; 2]],
    group: usize,
}

impl RowKernel for PooledLayersKernel<'_> {
    #[inline(always)]
    fn compute<const FMA: bool>(&self, groups: Range<usize>, out: &mut [f32]) {
        let n_out = out.len() / groups.len().max(1);
        let size = self.group * self.x.n_cols();
        let mut mapped = vec![0.0; self.group * n_out];
        for (n, out) in groups.zip(out.chunks_exact_mut(n_out.max(1))) {
            mapped.fill(0.0);
            apply_layers::<FMA>(&self.x.data()[n * size..][..size], &[], self.layers, &mut mapped);
            out.copy_from_slice(&mapped[..n_out]);
            for row in mapped.chunks_exact(n_out).skip(1) {
                out.iter_mut().zip(row).for_each(|(out, &x)| *out = if x > *out { x } else { *out });
            }
        }
    }
}

struct GroupScoresKernel<'a> {
    x: &'a Matrix,
    group_rows: &'a Matrix,
    layers: &'a [[&'a Matrix; 2]],
    group: usize,
}

impl RowKernel for GroupScoresKernel<'_> {
    #[inline(always)]
    fn compute<const FMA: bool>(&self, groups: Range<usize>, out: &mut [f32]) {
        let size = self.group * self.x.n_cols();
        for (n, out) in groups.zip(out.chunks_exact_mut(self.group)) {
            let rows = &self.x.data()[n * size..][..size];
            apply_layers::<FMA>(rows, self.group_rows.row(n), self.layers, out);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_values::{assert_close, random};
    use super::super::{group_max, product};
    use super::*;

    #[test]
    fn every_instruction_set_agrees_with_one_layer_after_the_other() {
        let widths = [6, 16, 9, 1];
        let parameters: Vec<[Matrix; 2]> =
            (0..3).map(|i| [random(widths[i], widths[i + 1], i as u64), random(1, widths[i + 1], 9)]).collect();
        let layers: Vec<[&Matrix; 2]> = parameters.iter().map(|layer| layer.each_ref()).collect();
        let (x, group_rows) = (random(70 * 5, 6, 4), random(70, 16, 5));
        let relu = |mut m: Matrix| {
            m.data_mut().iter_mut().for_each(|y| *y = y.max(0.0));
            m
        };
        let after = |first: Matrix, last: usize| {
            let second = product(&relu(first), layers[1][0], layers[1][1].data());
            if last == 1 { second } else { product(&relu(second), layers[2][0], layers[2][1].data()) }
        };
        let first = product(&x, layers[0][0], layers[0][1].data());
        let with_groups = Matrix::from_fn(350, 16, |i, c| first.row(i)[c] + group_rows.row(i / 5)[c]);
        Isa::on_each(|| {
            let pooled = layers_group_max(&x, &layers[..2], 5);
            assert_close(pooled.data(), group_max(&after(first.clone(), 1), 5).largest.data(), 1e-5);
            let scored = layers_with_group_rows(&x, &group_rows, &layers, 5);
            assert_close(scored.data(), after(with_groups.clone(), 2).data(), 1e-5);
        });
        assert_eq!(layers_group_max(&Matrix::zeros(0, 6), &layers, 5).shape(), [0, 1]);
    }
}
