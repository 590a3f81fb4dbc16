//! A dense matrix.

/// An `f32` matrix, n_rows x n_cols, row-major.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::Matrix;
/// let m = Matrix::new(2, 3, vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
/// assert_eq!(m.row(1), [4.0, 5.0, 6.0]);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Matrix {
    n_rows: usize,
    n_cols: usize,
    data: Vec<f32>,
}

impl Matrix {
    /// Wraps `data`, n_rows x n_cols.
    pub fn new(n_rows: usize, n_cols: usize, data: Vec<f32>) -> Self {
        assert_eq!(data.len(), n_rows * n_cols, "a {n_rows} x {n_cols} matrix");
        Self { n_rows, n_cols, data }
    }

    /// Returns a matrix of zeros.
    pub fn zeros(n_rows: usize, n_cols: usize) -> Self {
        Self::new(n_rows, n_cols, vec![0.0; n_rows * n_cols])
    }

    /// Copies points into rows, n_points x 3.
    pub fn from_points(points: &[[f32; 3]]) -> Self {
        Self::new(points.len(), 3, points.as_flattened().to_vec())
    }

    /// Wraps points as rows without copying.
    pub fn from_owned_points(points: Vec<[f32; 3]>) -> Self {
        Self::new(points.len(), 3, points.into_flattened())
    }

    /// Builds the matrix with the entries `entry(row, col)`.
    pub fn from_fn(n_rows: usize, n_cols: usize, mut entry: impl FnMut(usize, usize) -> f32) -> Self {
        let indices = (0..n_rows).flat_map(|row| (0..n_cols).map(move |col| (row, col)));
        Self::new(n_rows, n_cols, indices.map(|(row, col)| entry(row, col)).collect())
    }

    /// Returns the number of rows.
    pub fn n_rows(&self) -> usize {
        self.n_rows
    }

    /// Returns the number of columns.
    pub fn n_cols(&self) -> usize {
        self.n_cols
    }

    /// Returns the numbers of rows and columns.
    pub fn shape(&self) -> [usize; 2] {
        [self.n_rows, self.n_cols]
    }

    /// Returns all entries, row by row.
    pub fn data(&self) -> &[f32] {
        &self.data
    }

    /// Returns all entries, row by row, for writing.
    pub fn data_mut(&mut self) -> &mut [f32] {
        &mut self.data
    }

    /// Converts into the entries, row by row.
    pub fn into_data(self) -> Vec<f32> {
        self.data
    }

    /// Returns one row.
    #[inline]
    pub fn row(&self, row: usize) -> &[f32] {
        &self.data[row * self.n_cols..][..self.n_cols]
    }

    #[inline(always)]
    pub(crate) fn window<const COLS: usize>(&self, row: usize, col: usize) -> &[f32; COLS] {
        window(&self.data, row * self.n_cols + col)
    }

    /// Returns the transposed matrix, n_cols x n_rows.
    pub fn transpose(&self) -> Self {
        Self::from_fn(self.n_cols, self.n_rows, |row, col| self.data[col * self.n_cols + row])
    }
}

#[inline(always)]
pub(crate) fn window<const COLS: usize>(values: &[f32], at: usize) -> &[f32; COLS] {
    values[at..].first_chunk().expect("the window must be inside the values")
}

#[cfg(test)]
mod tests {
    use super::super::test_values::random;

    #[test]
    fn transposing_twice_changes_nothing() {
        let m = random(5, 3, 1);
        assert_eq!(m.transpose().shape(), [3, 5]);
        assert_eq!(m.transpose().transpose(), m);
    }
}
