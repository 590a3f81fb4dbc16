//! Products of tall matrices by slabs of rows: in parallel, with sums in a fixed order.

use nalgebra::{DMatrix, DMatrixView};
use neural_mesh::parallel;

// Number of rows of a slab, which then fits the nearest cache.
const ROWS: usize = 1024;

/// Computes `a^T b` of two tall matrices.
pub fn inner_products(a: &DMatrixView<'_, f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let parts = parallel::each(slabs(a.nrows()), |(start, n)| a.rows(start, n).tr_mul(&b.rows(start, n)));
    parts.into_iter().fold(DMatrix::zeros(a.ncols(), b.ncols()), |sum, part| sum + part)
}

/// Computes `a b` of a tall matrix and a small one.
pub fn product(a: &DMatrixView<'_, f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let parts = parallel::each(slabs(a.nrows()), |(start, n)| a.rows(start, n) * b);
    let mut whole = DMatrix::zeros(a.nrows(), b.ncols());
    slabs(a.nrows()).zip(parts).for_each(|((start, n), part)| whole.rows_mut(start, n).copy_from(&part));
    whole
}

fn slabs(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).step_by(ROWS).map(move |start| (start, ROWS.min(n - start)))
}
