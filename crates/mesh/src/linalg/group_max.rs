//! Column maxima over groups of rows.

use super::Matrix;
use super::isa::{Isa, RowKernel, multiply_add};
use super::product::{add_bias, column_sums, multiply_rows};
use std::ops::Range;

/// Column maxima of groups of rows, with the rows that attain them.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupMax {
    /// Maxima, n_groups x n_cols.
    pub largest: Matrix,
    /// Row of each maximum, the first of equal ones; n_groups x n_cols, row-major.
    pub rows: Vec<u32>,
}

/// Finds column maxima over groups of `group` rows.
///
/// # Shapes
/// - `x`: (n_groups * group) x n_cols
/// - returns n_groups x n_cols
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::{Matrix, group_max};
/// let found = group_max(&Matrix::new(4, 1, vec![1.0, 3.0, 7.0, 5.0]), 2);
/// assert_eq!((found.largest.data(), &found.rows[..]), (&[3.0, 7.0][..], &[1, 2][..]));
/// ```
pub fn group_max(x: &Matrix, group: usize) -> GroupMax {
    let n_groups = n_groups(x, group);
    let both = Isa::best().compute_matrix(&LargestKernel { x, group }, n_groups, 2 * x.n_cols());
    split_places(&both, group)
}

/// Computes the derivative of [`group_max`] to `x`, which has `n_rows` rows.
///
/// `rows` are those of its result; `gradient` is the derivative to its maxima.
pub fn group_max_backward(n_rows: usize, rows: &[u32], gradient: &Matrix) -> Matrix {
    let n_cols = gradient.n_cols();
    let mut to_x = Matrix::zeros(n_rows, n_cols);
    for (at, (&row, &g)) in rows.iter().zip(gradient.data()).enumerate() {
        to_x.data_mut()[row as usize * n_cols + at % n_cols] += g;
    }
    to_x
}

/// Computes [`group_max`] of `x w + bias`.
///
/// # Shapes
/// - `x`: (n_groups * group) x n_in; `weights`: n_in x n_out; `bias`: 1 x n_out
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::{Matrix, group_max_affine};
/// let (x, number) = (Matrix::new(2, 1, vec![1.0, 3.0]), |x: f32| Matrix::new(1, 1, vec![x]));
/// let found = group_max_affine(&x, [&number(-2.0), &number(1.0)], 2);
/// assert_eq!((found.largest.data(), &found.rows[..]), (&[-1.0][..], &[0][..]));
/// ```
pub fn group_max_affine(x: &Matrix, layer: [&Matrix; 2], group: usize) -> GroupMax {
    let [n_in, n_out] = layer[0].shape();
    assert_eq!([x.n_cols(), n_out], [n_in, layer[1].data().len()], "sizes of x and of the layer must match");
    let kernel = LargestAffineKernel { x, layer, group };
    split_places(&Isa::best().compute_matrix(&kernel, n_groups(x, group), 2 * n_out), group)
}

/// Computes the derivatives of [`group_max_affine`] to x, weights and bias.
///
/// `rows` are those of its result; `gradient` is the derivative to its maxima.
pub fn group_max_affine_backward(x: &Matrix, weights: &Matrix, rows: &[u32], gradient: &Matrix) -> [Matrix; 3] {
    let isa = Isa::best();
    let [n_in, n_out] = weights.shape();
    let transposed = weights.transpose();
    let group = x.n_rows() / gradient.n_rows().max(1);
    let to_input = ToInputKernel { transposed: &transposed, rows, gradient, group };
    let to_x = isa.compute_matrix(&to_input, gradient.n_rows(), group * n_in);
    let to_weights = isa.compute_matrix(&ToWeightsKernel { x, rows, gradient }, n_out, n_in).transpose();
    [Matrix::new(x.n_rows(), n_in, to_x.into_data()), to_weights, column_sums(gradient)]
}

fn n_groups(x: &Matrix, group: usize) -> usize {
    assert!(group > 0 && x.n_rows().is_multiple_of(group), "a whole number of groups of rows");
    x.n_rows() / group
}

fn split_places(both: &Matrix, group: usize) -> GroupMax {
    let n_cols = both.n_cols() / 2;
    let (mut largest, mut rows) = (Vec::with_capacity(both.data().len() / 2), Vec::new());
    for n in 0..both.n_rows() {
        let (values, places) = both.row(n).split_at(n_cols);
        largest.extend_from_slice(values);
        rows.extend(places.iter().map(|&place| (n * group) as u32 + place as u32));
    }
    GroupMax { largest: Matrix::new(both.n_rows(), n_cols, largest), rows }
}

/// Writes the column maxima of `rows` to `out`, then the indices of the rows that attain them.
#[inline(always)]
fn find_largest(rows: &[f32], out: &mut [f32]) {
    let n_cols = out.len() / 2;
    let (largest, places) = out.split_at_mut(n_cols);
    largest.copy_from_slice(&rows[..n_cols]);
    for (at, row) in rows.chunks_exact(n_cols.max(1)).enumerate().skip(1) {
        let at = at as f32;
        for ((x, largest), place) in row.iter().zip(largest.iter_mut()).zip(places.iter_mut()) {
            let is_larger = *x > *largest;
            *largest = if is_larger { *x } else { *largest };
            *place = if is_larger { at } else { *place };
        }
    }
}

struct LargestKernel<'a> {
    x: &'a Matrix,
    group: usize,
}

impl RowKernel for LargestKernel<'_> {
    #[inline(always)]
    fn compute<const FMA: bool>(&self, groups: Range<usize>, out: &mut [f32]) {
        let size = self.group * self.x.n_cols();
        for (n, out) in groups.zip(out.chunks_exact_mut((2 * self.x.n_cols()).max(1))) {
            find_largest(&self.x.data()[n * size..][..size], out);
        }
    }
}

struct LargestAffineKernel<'a> {
    x: &'a Matrix,
    layer: [&'a Matrix; 2],
    group: usize,
}

impl RowKernel for LargestAffineKernel<'_> {
    #[inline(always)]
    fn compute<const FMA: bool>(&self, groups: Range<usize>, out: &mut [f32]) {
        let [weights, bias] = self.layer;
        let (size, n_out) = (self.group * self.x.n_cols(), weights.n_cols());
        let mut mapped = vec![0.0; self.group * n_out];
        for (n, out) in groups.zip(out.chunks_exact_mut((2 * n_out).max(1))) {
            multiply_rows::<FMA>(&self.x.data()[n * size..][..size], weights, &mut mapped);
            add_bias(&mut mapped, bias.data());
            find_largest(&mapped, out);
        }
    }
}

struct ToInputKernel<'a> {
    transposed: &'a Matrix,
    rows: &'a [u32],
    gradient: &'a Matrix,
    group: usize,
}

impl RowKernel for ToInputKernel<'_> {
    #[inline(always)]
    fn compute<const FMA: bool>(&self, groups: Range<usize>, out: &mut [f32]) {
        let [n_out, n_in] = self.transposed.shape();
        for (n, out) in groups.zip(out.chunks_exact_mut((self.group * n_in).max(1))) {
            for (c, &g) in self.gradient.row(n).iter().enumerate() {
                let place = self.rows[n * n_out + c] as usize - n * self.group;
                add_times::<FMA>(&mut out[place * n_in..][..n_in], g, self.transposed.row(c));
            }
        }
    }
}

struct ToWeightsKernel<'a> {
    x: &'a Matrix,
    rows: &'a [u32],
    gradient: &'a Matrix,
}

impl RowKernel for ToWeightsKernel<'_> {
    #[inline(always)]
    fn compute<const FMA: bool>(&self, columns: Range<usize>, out: &mut [f32]) {
        let n_out = self.gradient.n_cols();
        for (c, out) in columns.zip(out.chunks_exact_mut(self.x.n_cols().max(1))) {
            for n in 0..self.gradient.n_rows() {
                add_times::<FMA>(out, self.gradient.row(n)[c], self.x.row(self.rows[n * n_out + c] as usize));
            }
        }
    }
}

#[inline(always)]
fn add_times<const FMA: bool>(to: &mut [f32], factor: f32, from: &[f32]) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to = multiply_add::<FMA>(factor, *from, *to));
}

#[cfg(test)]
mod tests {
    use super::super::product;
    use super::super::test_values::{assert_close, random};
    use super::*;

    #[test]
    fn the_largest_of_groups_and_the_first_of_equal_ones() {
        let x = Matrix::new(4, 2, vec![1.0, 5.0, 3.0, 5.0, -1.0, -2.0, -3.0, 0.0]);
        let found = group_max(&x, 2);
        assert_eq!(found, GroupMax { largest: Matrix::new(2, 2, vec![3.0, 5.0, -1.0, 0.0]), rows: vec![1, 0, 2, 3] });
        assert_eq!(group_max(&Matrix::zeros(0, 3), 5).largest.shape(), [0, 3]);
    }

    #[test]
    fn every_instruction_set_agrees_with_one_step_after_the_other() {
        Isa::on_each(|| {
            for [n_groups, group, n_in, n_out] in [[0, 3, 4, 1], [7, 64, 32, 256], [70, 5, 9, 17], [3, 1, 2, 2]] {
                let (x, w, b) = (random(n_groups * group, n_in, 1), random(n_in, n_out, 2), random(1, n_out, 3));
                let found = group_max_affine(&x, [&w, &b], group);
                let expected = group_max(&product(&x, &w, b.data()), group);
                assert_close(found.largest.data(), expected.largest.data(), 1e-5);
                let n_equal = found.rows.iter().zip(&expected.rows).filter(|(a, b)| a == b).count();
                assert!(n_equal * 100 >= found.rows.len() * 99, "rounding turns hardly a choice");
            }
        });
    }
}
