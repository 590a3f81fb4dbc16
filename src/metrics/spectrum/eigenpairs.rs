//! The lowest eigenvalues and eigenfunctions of a surface's Laplacian.

use faer::{Mat, MatMut, MatRef, Side};

use super::factor::Factor;
use super::lanczos;
use crate::metrics::laplacian::Laplacian;

/// Surfaces with so few vertices, or not three times as many as pairs, are solved as dense matrices.
const DENSE: usize = 400;

/// The lowest eigenpairs of `L u = lambda M u`.
#[derive(Clone, Debug)]
pub struct Eigenpairs {
    /// Eigenvalues in inverse squares of the mesh's unit, ascending, at least 0: n_pairs.
    pub values: Vec<f64>,
    /// Eigenfunctions at the places of [`Laplacian::vertices`], as columns, orthonormal under the masses: n x n_pairs.
    functions: Mat<f64>,
}

impl Eigenpairs {
    /// Solves for the `n_pairs` lowest, at most n; `None` where the solver fails.
    ///
    /// Shift-invert block Lanczos over a sparse Cholesky factor. An eigenvalue that is there more than eight times may be
    /// found fewer times: surfaces of many equal pieces have such.
    ///
    /// ```
    /// use neural_mesh::{mesh::shapes, metrics::{Eigenpairs, Laplacian}};
    /// let sphere = Laplacian::new(&shapes::icosphere(3)).unwrap();
    /// let values = Eigenpairs::lowest(&sphere, 4).unwrap().values;
    /// assert!(values[0] < 1e-9 && values[1..].iter().all(|value| (value - 2.0).abs() < 0.02));
    /// ```
    pub fn lowest(laplacian: &Laplacian, n_pairs: usize) -> Option<Self> {
        let roots: Vec<f64> = laplacian.mass.iter().map(|mass| mass.sqrt()).collect();
        let n_pairs = n_pairs.min(roots.len());
        let small = roots.len() <= DENSE.max(3 * n_pairs);
        let solve = if small { dense } else { sparse };
        let (values, mut functions) = solve(laplacian, &roots, n_pairs)?;
        scale_rows(functions.as_mut(), &roots.iter().map(|root| 1.0 / root).collect::<Vec<_>>());
        Some(Self { values: values.into_iter().map(|value| value.max(0.0)).collect(), functions })
    }

    /// The eigenfunction of an eigenvalue, at the places of [`Laplacian::vertices`]: n.
    pub fn function(&self, pair: usize) -> &[f64] {
        self.functions.col_as_slice(pair)
    }

    /// The eigenfunctions of the first eigenvalues, as columns, n x n_pairs.
    pub(super) fn first(&self, n_pairs: usize) -> MatRef<'_, f64> {
        self.functions.subcols(0, n_pairs)
    }

    /// By Weyl's law the eigenvalues are evenly spaced, about this far apart; 0 where there is only one.
    pub fn spacing(&self) -> f64 {
        self.values.last().map_or(0.0, |last| last / (self.values.len() - 1).max(1) as f64)
    }
}

/// By all eigenpairs of `M^-1/2 L M^-1/2`.
fn dense(laplacian: &Laplacian, roots: &[f64], n_pairs: usize) -> Option<(Vec<f64>, Mat<f64>)> {
    let mut matrix = Mat::<f64>::zeros(roots.len(), roots.len());
    for &([i, j], weight) in &laplacian.edges {
        let (i, j) = (i as usize, j as usize);
        matrix[(i, i)] += weight / (roots[i] * roots[i]);
        matrix[(j, j)] += weight / (roots[j] * roots[j]);
        matrix[(j, i)] -= weight / (roots[i] * roots[j]);
    }
    let eigen = matrix.self_adjoint_eigen(Side::Lower).ok()?;
    let values = (0..n_pairs).map(|i| eigen.S().column_vector()[i]).collect();
    Some((values, eigen.U().subcols(0, n_pairs).to_owned()))
}

/// By the largest eigenpairs of `M^1/2 (L + s M)^-1 M^1/2`, the shift s about as large as the first eigenvalue.
fn sparse(laplacian: &Laplacian, roots: &[f64], n_pairs: usize) -> Option<(Vec<f64>, Mat<f64>)> {
    let shift = 4.0 * std::f64::consts::PI / laplacian.mass.iter().sum::<f64>();
    let factor = Factor::new(laplacian, 1.0, shift)?;
    let apply = |mut block: MatMut<'_, f64>| {
        scale_rows(block.as_mut(), roots);
        factor.solve_in_place(block.as_mut());
        scale_rows(block, roots);
    };
    let (inverse, functions) = lanczos::largest(roots.len(), n_pairs, apply)?;
    Some((inverse.into_iter().map(|value| 1.0 / value - shift).collect(), functions))
}

fn scale_rows(mut matrix: MatMut<'_, f64>, by: &[f64]) {
    for j in 0..matrix.ncols() {
        by.iter().enumerate().for_each(|(i, factor)| matrix[(i, j)] *= factor);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{TriMesh, shapes};

    fn lowest(mesh: &TriMesh, n_pairs: usize) -> Eigenpairs {
        Eigenpairs::lowest(&Laplacian::new(mesh).unwrap(), n_pairs).unwrap()
    }

    /// l (l + 1), each 2 l + 1 times.
    #[test]
    fn eigenvalues_of_the_sphere() {
        let values = lowest(&shapes::icosphere(4), 49).values;
        let wanted = (0..7).flat_map(|l| std::iter::repeat_n(f64::from(l * (l + 1)), 2 * l as usize + 1));
        for (value, wanted) in values.iter().zip(wanted) {
            assert!((value - wanted).abs() <= 0.02 * wanted + 1e-9, "{value} {wanted}");
        }
    }

    /// pi^2 (i^2 + j^2), as no flow leaves the border.
    #[test]
    fn eigenvalues_of_the_square() {
        let values = lowest(&shapes::grid(40, 40), 20).values;
        let mut wanted: Vec<f64> = (0..40).map(|i| f64::from(i / 6 * (i / 6) + i % 6 * (i % 6))).collect();
        wanted.sort_by(f64::total_cmp);
        for (value, wanted) in values.iter().zip(wanted.iter().map(|w| w * std::f64::consts::PI.powi(2))) {
            assert!((value - wanted).abs() <= 0.01 * wanted + 1e-9, "{value} {wanted}");
        }
    }

    #[test]
    fn functions_are_eigenfunctions_and_orthonormal() {
        let laplacian = Laplacian::new(&shapes::wavy_sphere(3, 20.0)).unwrap();
        assert!(laplacian.mass.len() > DENSE);
        let pairs = Eigenpairs::lowest(&laplacian, 60).unwrap();
        for k in [0, 1, 30, 59] {
            let u = pairs.function(k);
            let mut left: Vec<f64> = u.iter().zip(&laplacian.mass).map(|(u, m)| -pairs.values[k] * m * u).collect();
            for &([i, j], weight) in &laplacian.edges {
                let flow = weight * (u[i as usize] - u[j as usize]);
                left[i as usize] += flow;
                left[j as usize] -= flow;
            }
            let error = left.iter().zip(&laplacian.mass).map(|(r, m)| r * r / m).sum::<f64>().sqrt();
            assert!(error < 1e-5 * (pairs.values[k] + 1.0), "{k} {error}");
            let inner = |l: usize| u.iter().zip(pairs.function(l)).zip(&laplacian.mass).map(|((a, b), m)| a * b * m);
            for l in 0..60 {
                assert!((inner(l).sum::<f64>() - f64::from(u8::from(k == l))).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn dense_and_sparse_agree() {
        let laplacian = Laplacian::new(&shapes::wavy_sphere(3, 20.0)).unwrap();
        let roots: Vec<f64> = laplacian.mass.iter().map(|mass| mass.sqrt()).collect();
        let (dense, _) = dense(&laplacian, &roots, 60).unwrap();
        let (sparse, _) = sparse(&laplacian, &roots, 60).unwrap();
        assert!(dense.iter().zip(&sparse).all(|(a, b)| (a - b).abs() < 1e-7 * (a + 1.0)), "{dense:?} {sparse:?}");
    }
}
