//! Largest eigenpairs by block Lanczos with full reorthogonalisation (Golub and Underwood 1977).

use nalgebra::{DMatrix, DMatrixView};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

use super::slabs::{inner_products, product};
use super::symmetric::symmetric_eigenpairs;

const WIDTH: usize = 8;
// Largest residual of a converged pair relative to its eigenvalue.
const TOLERANCE: f64 = 1e-8;
// Largest number of basis columns per eigenpair; two are usual.
const MOST: usize = 5;
// Further basis columns, because each of few eigenpairs needs more than `MOST`.
const SPARE: usize = 512;

struct Krylov {
    // Orthonormal columns, `len` and one more block.
    basis: DMatrix<f64>,
    // The projected operator, lower triangle.
    projected: DMatrix<f64>,
    len: usize,
    rng: Xoshiro256PlusPlus,
}

/// Computes the `n_pairs` largest eigenpairs, values descending; `apply` multiplies a block of columns in place.
pub fn largest_eigenpairs(
    n: usize,
    n_pairs: usize,
    apply: impl Fn(&mut DMatrix<f64>),
) -> Option<(Vec<f64>, DMatrix<f64>)> {
    let capacity = (MOST * n_pairs + SPARE).min(n.saturating_sub(WIDTH)) / WIDTH * WIDTH;
    let mut krylov = Krylov::new(n, capacity + WIDTH);
    let mut next_look = n_pairs + n_pairs / 2;
    while krylov.len < capacity {
        let last = krylov.step(&apply);
        // Converged pairs are searched only now and then, because the dense solve is expensive.
        if krylov.len >= next_look {
            if let Some(found) = krylov.ritz_pairs(n_pairs, &last) {
                return Some(found);
            }
            next_look = krylov.len + n_pairs / 5;
        }
    }
    None
}

impl Krylov {
    fn new(n: usize, capacity: usize) -> Self {
        let rng = Xoshiro256PlusPlus::seed_from_u64(0);
        let (basis, projected) = (DMatrix::zeros(n, 0), DMatrix::zeros(capacity, capacity));
        let mut krylov = Self { basis, projected, len: 0, rng };
        krylov.push(DMatrix::zeros(n, WIDTH));
        krylov
    }

    fn step(&mut self, apply: &impl Fn(&mut DMatrix<f64>)) -> DMatrix<f64> {
        let (from, to) = (self.len, self.len + WIDTH);
        let mut block = self.basis.columns_range(from..to).into_owned();
        apply(&mut block);
        self.len = to;
        // In exact arithmetic only the last two blocks matter; `push` removes rounding from the others.
        let near = from.saturating_sub(WIDTH);
        let inside = project_out(&self.basis.columns_range(near..to), &mut block);
        self.projected.view_mut((from, from), (WIDTH, WIDTH)).copy_from(&inside.rows(from - near, WIDTH));
        let link = self.push(block);
        self.projected.view_mut((to, from), (WIDTH, WIDTH)).copy_from(&link);
        link
    }

    fn push(&mut self, mut block: DMatrix<f64>) -> DMatrix<f64> {
        let first = self.orthonormalise(&mut block);
        project_out(&self.basis.as_view(), &mut block);
        let second = self.orthonormalise(&mut block);
        self.basis.extend(block.column_iter());
        second * first
    }

    fn orthonormalise(&mut self, block: &mut DMatrix<f64>) -> DMatrix<f64> {
        // The result is the triangle R of block = Q R.
        let mut triangle = DMatrix::zeros(WIDTH, WIDTH);
        for j in 0..WIDTH {
            let (earlier, mut column) = (block.columns(0, j), block.columns(j, 1).into_owned());
            let before = column.norm();
            let mut inside = project_out(&earlier, &mut column);
            let left = column.norm();
            if left > 1e-10 * before {
                triangle[(j, j)] = left;
                inside += project_out(&earlier, &mut column);
            } else {
                // A dependent column is replaced by a random one.
                column = self.random_column();
                (0..2).for_each(|_| drop(project_out(&earlier, &mut column)));
            }
            triangle.view_mut((0, j), (j, 1)).copy_from(&inside);
            block.columns_mut(j, 1).copy_from(&column.normalize());
        }
        triangle
    }

    fn random_column(&mut self) -> DMatrix<f64> {
        let uniform = |rng: &mut Xoshiro256PlusPlus| (rng.next_u64() >> 11) as f64 / (1u64 << 52) as f64 - 1.0;
        let mut column = DMatrix::from_fn(self.basis.nrows(), 1, |_, _| uniform(&mut self.rng));
        (0..2).for_each(|_| drop(project_out(&self.basis.as_view(), &mut column)));
        column
    }

    fn ritz_pairs(&self, n_pairs: usize, link: &DMatrix<f64>) -> Option<(Vec<f64>, DMatrix<f64>)> {
        let projected = self.projected.view((0, 0), (self.len, self.len)).into_owned();
        let (values, turned) = symmetric_eigenpairs(projected)?;
        let largest = |i: usize| self.len - 1 - i;
        let is_found = |i: usize| {
            let end = turned.view((self.len - WIDTH, largest(i)), (WIDTH, 1));
            (link * end).norm() <= TOLERANCE * values[largest(i)].abs()
        };
        if n_pairs > self.len || !(0..n_pairs).all(is_found) {
            return None;
        }
        let order: Vec<usize> = (0..n_pairs).map(largest).collect();
        let vectors = product(&self.basis.columns(0, self.len), &turned.select_columns(&order));
        Some((order.iter().map(|&i| values[i]).collect(), vectors))
    }
}

fn project_out(basis: &DMatrixView<'_, f64>, block: &mut DMatrix<f64>) -> DMatrix<f64> {
    let inside = inner_products(basis, block);
    *block -= product(basis, &inside);
    inside
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solve_diagonal(diagonal: &[f64], n_pairs: usize) -> (Vec<f64>, DMatrix<f64>) {
        let apply = |block: &mut DMatrix<f64>| {
            for j in 0..block.ncols() {
                (0..block.nrows()).for_each(|i| block[(i, j)] *= diagonal[i]);
            }
        };
        largest_eigenpairs(diagonal.len(), n_pairs, apply).unwrap()
    }

    #[test]
    fn the_largest_of_a_diagonal_are_its_largest() {
        let diagonal: Vec<f64> = (1..=900).map(|i| 1.0 / f64::from(i)).collect();
        let (values, vectors) = solve_diagonal(&diagonal, 40);
        for (i, value) in values.iter().enumerate() {
            assert!((value - diagonal[i]).abs() < 1e-13, "{i} {value}");
            assert!((vectors[(i, i)].abs() - 1.0).abs() < 1e-6);
        }
        let gram = vectors.transpose() * &vectors;
        assert!((gram - DMatrix::<f64>::identity(40, 40)).amax() < 1e-12);
    }

    #[test]
    fn values_that_are_several_times_there_are_found_as_often() {
        let diagonal: Vec<f64> = (0..900).map(|i| 1.0 / f64::from(1 + i / 7)).collect();
        let (values, _) = solve_diagonal(&diagonal, 63);
        assert!(values.iter().zip(&diagonal).all(|(a, b)| (a - b).abs() < 1e-12), "{values:?}");
    }
}
