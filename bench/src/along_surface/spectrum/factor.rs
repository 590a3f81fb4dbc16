//! Sparse Cholesky factors.

use nalgebra::DMatrix;
use nalgebra_sparse::factorization::CscCholesky;
use nalgebra_sparse::{CooMatrix, CscMatrix};
use neural_mesh::parallel;

pub struct Factor {
    cholesky: CscCholesky<f64>,
    // Vertex of each row of the factor, n.
    order: Vec<usize>,
}

impl Factor {
    pub fn new(mass: &[f64], edges: &[([u32; 2], f64)], a: f64, b: f64) -> Option<Self> {
        let n = mass.len();
        // The matrix is `a L + b M`; rounding may make it indefinite, then there is no factor.
        let mut entries = CooMatrix::new(n, n);
        mass.iter().enumerate().for_each(|(i, mass)| entries.push(i, i, b * mass));
        for &([i, j], weight) in edges {
            for [i, j] in [[i as usize, j as usize], [j as usize, i as usize]] {
                entries.push(i, i, a * weight);
                entries.push(i, j, -a * weight);
            }
        }
        let matrix = CscMatrix::from(&entries);
        // Rows by approximate minimum degree (Amestoy, Davis and Duff 1996) keep the factor sparse.
        let (order, row, _) =
            amd::order(n, matrix.col_offsets(), matrix.row_indices(), &amd::Control::default()).ok()?;
        let ordered = matrix.triplet_iter().map(|(i, j, &value)| (row[i], row[j], value));
        let ordered = CscMatrix::from(&CooMatrix::try_from_triplets_iter(n, n, ordered).ok()?);
        Some(Self { cholesky: CscCholesky::factor(&ordered).ok()?, order })
    }

    pub fn solve_in_place(&self, columns: &mut DMatrix<f64>) {
        let n = self.order.len();
        parallel::rows_mut(columns.as_mut_slice(), n, 1, |_, column| {
            let mut solution = DMatrix::from_fn(n, 1, |i, _| column[self.order[i]]);
            self.cholesky.solve_mut(&mut solution);
            self.order.iter().zip(&solution).for_each(|(&v, &value)| column[v] = value);
        });
    }

    pub fn solve(&self, right: &[f64]) -> Vec<f64> {
        let mut column = DMatrix::from_column_slice(right.len(), 1, right);
        self.solve_in_place(&mut column);
        column.data.into()
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
