//! Eigenpairs of dense symmetric matrices.

use nalgebra::{DMatrix, SymmetricEigen};

/// Largest number of iterations per row before a decomposition fails, as in LAPACK's `dsteqr`.
pub const MOST_ITERATIONS: usize = 30;

/// Computes all eigenpairs of a symmetric matrix from its lower triangle, values ascending.
pub fn symmetric_eigenpairs(matrix: DMatrix<f64>) -> Option<(Vec<f64>, DMatrix<f64>)> {
    let most = MOST_ITERATIONS * matrix.nrows();
    let eigen = SymmetricEigen::try_new(matrix, f64::EPSILON, most)?;
    let values = eigen.eigenvalues;
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&i, &j| values[i].total_cmp(&values[j]));
    Some((order.iter().map(|&i| values[i]).collect(), eigen.eigenvectors.select_columns(&order)))
}
