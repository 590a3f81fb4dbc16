//! Sparse Cholesky factors.

use faer::prelude::Solve;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, MatMut, Side};
use neural_mesh::parallel;

pub struct Factor {
    llt: Llt<u32, f64>,
}

impl Factor {
    pub fn new(mass: &[f64], edges: &[([u32; 2], f64)], a: f64, b: f64) -> Option<Self> {
        let n = mass.len();
        // The matrix is `a L + b M`; rounding may make it indefinite, then there is no factor.
        let mut diagonal: Vec<f64> = mass.iter().map(|mass| b * mass).collect();
        let mut entries = Vec::with_capacity(n + edges.len());
        for &([i, j], weight) in edges {
            entries.push(Triplet::new(j, i, -a * weight));
            diagonal[i as usize] += a * weight;
            diagonal[j as usize] += a * weight;
        }
        entries.extend(diagonal.iter().enumerate().map(|(i, &value)| Triplet::new(i as u32, i as u32, value)));
        let matrix = SparseColMat::try_new_from_triplets(n, n, &entries).ok()?;
        let symbolic = SymbolicLlt::try_new(matrix.symbolic(), Side::Lower).ok()?;
        Llt::try_new_with_symbolic(symbolic, matrix.as_ref(), Side::Lower).ok().map(|llt| Self { llt })
    }

    pub fn solve_in_place(&self, columns: MatMut<'_, f64>) {
        let half = columns.ncols() / 2;
        let (some, others) = columns.split_at_col_mut(half);
        parallel::join(|| self.llt.solve_in_place(some), || self.llt.solve_in_place(others));
    }

    pub fn solve(&self, right: &[f64]) -> Vec<f64> {
        let mut column = Mat::from_fn(right.len(), 1, |i, _| right[i]);
        self.solve_in_place(column.as_mut());
        (0..right.len()).map(|i| column[(i, 0)]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::along_surface::Laplacian;
    use neural_mesh::mesh::shapes;

    #[test]
    fn solutions_solve() {
        let laplacian = Laplacian::new(&shapes::icosphere(2)).unwrap();
        let right: Vec<f64> = (0..laplacian.mass.len()).map(|i| (i as f64).sin()).collect();
        let u = Factor::new(&laplacian.mass, &laplacian.edges, 2.0, 3.0).unwrap().solve(&right);
        let mut back: Vec<f64> = u.iter().zip(&laplacian.mass).map(|(u, mass)| 3.0 * mass * u).collect();
        for &([i, j], weight) in &laplacian.edges {
            let flow = 2.0 * weight * (u[i as usize] - u[j as usize]);
            back[i as usize] += flow;
            back[j as usize] -= flow;
        }
        assert!(back.iter().zip(&right).all(|(a, b)| (a - b).abs() < 1e-10));
    }
}
