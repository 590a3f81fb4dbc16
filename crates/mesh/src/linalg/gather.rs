//! Picks rows by index.

use super::Matrix;
use crate::parallel;

const MIN_TRIPLES: usize = 1024;

/// Picks rows: row n of the result is row `indices[n]` of `x`.
///
/// # Shapes
/// - `x`: n_rows x n_cols
/// - returns n_indices x n_cols
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::{Matrix, gather};
/// let x = Matrix::new(2, 1, vec![5.0, 7.0]);
/// assert_eq!(gather(&x, &[1, 1, 0]).data(), [7.0, 7.0, 5.0]);
/// ```
pub fn gather(x: &Matrix, indices: &[u32]) -> Matrix {
    let picked = indices.iter().flat_map(|&row| x.row(row as usize)).copied();
    Matrix::new(indices.len(), x.n_cols(), picked.collect())
}

/// Computes the derivative of [`gather`] to `x`, n_rows x n_cols.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::{Matrix, gather_backward};
/// let gradient = Matrix::new(3, 1, vec![1.0, 10.0, 100.0]);
/// assert_eq!(gather_backward(2, &[1, 1, 0], &gradient).data(), [100.0, 11.0]);
/// ```
pub fn gather_backward(n_rows: usize, indices: &[u32], gradient: &Matrix) -> Matrix {
    assert_eq!(indices.len(), gradient.n_rows(), "one gradient row per index");
    let n_cols = gradient.n_cols();
    let mut to_x = Matrix::zeros(n_rows, n_cols);
    for (at, &row) in indices.iter().enumerate() {
        let sums = &mut to_x.data_mut()[row as usize * n_cols..][..n_cols];
        sums.iter_mut().zip(gradient.row(at)).for_each(|(sum, g)| *sum += g);
    }
    to_x
}

/// Computes `[least | largest | mean]` of triples of rows i, j, k, by column, for Eq. (4).
///
/// Least and largest are those of `x_i - x_j`, `x_i - x_k`, `x_j - x_k`.
///
/// # Shapes
/// - `x`: n x n_cols, `triples`: n_triples x 3
/// - returns n_triples x (3 n_cols)
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::{Matrix, triple_extremes};
/// let x = Matrix::new(3, 1, vec![1.0, 2.0, 6.0]);
/// // Differences: -1, -5, -4.
/// assert_eq!(triple_extremes(&x, &[[0, 1, 2]]).data(), [-5.0, -1.0, 3.0]);
/// ```
pub fn triple_extremes(x: &Matrix, triples: &[[u32; 3]]) -> Matrix {
    let n_cols = x.n_cols();
    let mut result = Matrix::zeros(triples.len(), 3 * n_cols);
    parallel::rows_mut(result.data_mut(), 3 * n_cols, MIN_TRIPLES, |number, row| {
        let [i, j, k] = triples[number].map(|row| x.row(row as usize));
        for col in 0..n_cols {
            let column = [i[col], j[col], k[col]];
            row[col] = differences(column).into_iter().fold(f32::INFINITY, f32::min);
            row[n_cols + col] = differences(column).into_iter().fold(f32::NEG_INFINITY, f32::max);
            row[2 * n_cols + col] = (column[0] + column[1] + column[2]) / 3.0;
        }
    });
    result
}

/// Computes the derivative of [`triple_extremes`] to `x`, n x n_cols; ties go to the first difference.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::{Matrix, triple_extremes_backward};
/// let x = Matrix::new(3, 1, vec![1.0, 2.0, 6.0]);
/// let gradient = Matrix::new(1, 3, vec![10.0, 100.0, 3.0]);
/// // The least is x_0 - x_2, the largest x_0 - x_1; the mean gives each a third.
/// assert_eq!(triple_extremes_backward(&x, &[[0, 1, 2]], &gradient).data(), [111.0, -99.0, -9.0]);
/// ```
pub fn triple_extremes_backward(x: &Matrix, triples: &[[u32; 3]], gradient: &Matrix) -> Matrix {
    let n_cols = x.n_cols();
    assert_eq!(gradient.shape(), [triples.len(), 3 * n_cols], "one gradient per entry");
    let mut to_x = Matrix::zeros(x.n_rows(), n_cols);
    for (at, triple) in triples.iter().enumerate() {
        for col in 0..n_cols {
            let column = triple.map(|row| x.row(row as usize)[col]);
            let [least, largest, mean] = [0, 1, 2].map(|part| gradient.row(at)[part * n_cols + col]);
            let shares = column_backward(column, [least, largest, mean]);
            for (&row, share) in triple.iter().zip(shares) {
                to_x.data_mut()[row as usize * n_cols + col] += share;
            }
        }
    }
    to_x
}

fn column_backward(column: [f32; 3], [least, largest, mean]: [f32; 3]) -> [f32; 3] {
    let differences = differences(column);
    let first = |wins: fn(f32, f32) -> bool| {
        (1..3).fold(0, |best, at| if wins(differences[at], differences[best]) { at } else { best })
    };
    let mut shares = [mean / 3.0; 3];
    for (pair, gradient) in [(first(|a, b| a < b), least), (first(|a, b| a > b), largest)] {
        let [plus, minus] = [[0, 1], [0, 2], [1, 2]][pair];
        shares[plus] += gradient;
        shares[minus] -= gradient;
    }
    shares
}

fn differences([i, j, k]: [f32; 3]) -> [f32; 3] {
    [i - j, i - k, j - k]
}

#[cfg(test)]
mod tests {
    use super::super::test_values::{assert_close, assert_slopes, random};
    use super::*;

    const TRIPLES: [[u32; 3]; 4] = [[0, 1, 2], [2, 7, 5], [3, 2, 0], [4, 4, 6]];

    #[test]
    fn gathering_and_scattering_are_transposed() {
        let (x, g, indices) = (random(9, 4, 1), random(6, 4, 2), [3, 3, 0, 8, 3, 1]);
        let dot = |a: &Matrix, b: &Matrix| a.data().iter().zip(b.data()).map(|(a, b)| a * b).sum::<f32>();
        let forth = dot(&gather(&x, &indices), &g);
        assert_close(&[forth], &[dot(&x, &gather_backward(9, &indices, &g))], 1e-6);
    }

    #[test]
    fn gradients_of_triples_are_slopes_in_double_precision() {
        let (x, gradient) = (random(8, 3, 3), random(4, 9, 4));
        assert_slopes(triple_extremes_backward(&x, &TRIPLES, &gradient).data(), x.data(), |x| {
            let value = |(n, c): (usize, usize)| {
                let [i, j, k] = TRIPLES[n].map(|v| x[v as usize * 3 + c]);
                let edges = [i - j, i - k, j - k];
                let least = edges.into_iter().fold(f64::INFINITY, f64::min);
                let largest = edges.into_iter().fold(f64::NEG_INFINITY, f64::max);
                let rows = [least, largest, (i + j + k) / 3.0];
                (0..3).map(|part| f64::from(gradient.row(n)[part * 3 + c]) * rows[part]).sum::<f64>()
            };
            (0..4).flat_map(|n| [0, 1, 2].map(|c| (n, c))).map(value).sum()
        });
    }

    #[test]
    fn of_equal_differences_the_first_has_the_gradient() {
        let x = Matrix::new(3, 1, vec![0.0; 3]);
        let gradient = Matrix::new(1, 3, vec![1.0, 10.0, 0.0]);
        assert_eq!(triple_extremes_backward(&x, &[[0, 1, 2]], &gradient).data(), [11.0, -11.0, 0.0]);
    }
}
