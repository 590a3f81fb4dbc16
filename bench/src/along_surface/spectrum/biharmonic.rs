//! The biharmonic distance (Lipman, Rustamov and Funkhouser 2010, Eq. 4).

use super::Eigenpairs;

impl Eigenpairs {
    /// Returns each vertex's biharmonic distance from vertex `source` in the mesh's unit, n.
    ///
    /// The squared distance is `sum_k (u_k(x) - u_k(y))^2 / lambda_k^2` over those of the first `n_pairs` eigenpairs
    /// with `lambda_k > 0`.
    ///
    /// # Panics
    /// If `source` is not below n.
    pub fn biharmonic_distances(&self, source: u32, n_pairs: usize) -> Vec<f64> {
        let mut squares = vec![0.0; self.first_functions(0).nrows()];
        for pair in 0..n_pairs.min(self.values.len()) {
            let (function, value) = (self.function(pair), self.values[pair]);
            let here = function[source as usize];
            // The eigenvalue of a constant function is zero up to rounding.
            if value <= 1e-6 * self.spacing() {
                continue;
            }
            squares.iter_mut().zip(function).for_each(|(sum, u)| *sum += ((u - here) / value).powi(2));
        }
        squares.into_iter().map(f64::sqrt).collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::along_surface::{Eigenpairs, Laplacian};
    use nalgebra::DMatrix;
    use neural_mesh::mesh::shapes;

    fn naive(laplacian: &Laplacian, source: usize) -> Vec<f64> {
        let n = laplacian.mass.len();
        let total: f64 = laplacian.mass.iter().sum();
        // The matrix `L + m m^T / total` is regular and agrees with L on functions of mean zero.
        let mut matrix = DMatrix::from_fn(n, n, |i, j| laplacian.mass[i] * laplacian.mass[j] / total);
        for &([i, j], weight) in &laplacian.edges {
            let (i, j) = (i as usize, j as usize);
            matrix[(i, i)] += weight;
            matrix[(j, j)] += weight;
            matrix[(i, j)] -= weight;
            matrix[(j, i)] -= weight;
        }
        let inverse = matrix.try_inverse().unwrap();
        let mass = DMatrix::from_fn(n, n, |i, j| if i == j { laplacian.mass[i] } else { 0.0 });
        let green = &inverse * mass * &inverse;
        (0..n).map(|i| (green[(i, i)] + green[(source, source)] - 2.0 * green[(i, source)]).max(0.0).sqrt()).collect()
    }

    #[test]
    fn agrees_with_a_dense_inverse() {
        let laplacian = Laplacian::new(&shapes::wavy_sphere(2, 20.0)).unwrap();
        let n = laplacian.mass.len();
        let naive = naive(&laplacian, 3);
        let largest = naive.iter().fold(0.0, |a: f64, b| a.max(*b));
        let all = Eigenpairs::compute_lowest(&laplacian, n).unwrap().biharmonic_distances(3, n);
        assert!(all.iter().zip(&naive).all(|(a, b)| (a - b).abs() < 1e-7 * largest));
        let some = Eigenpairs::compute_lowest(&laplacian, n / 4).unwrap().biharmonic_distances(3, n / 4);
        assert!(some.iter().zip(&naive).all(|(a, b)| (a - b).abs() < 0.05 * largest));
    }
}
