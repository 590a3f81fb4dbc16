//! Largest eigenpairs by block Lanczos with full reorthogonalisation (Golub and Underwood 1977).

use std::ops::Range;

use faer::{Mat, MatMut, MatRef, Side};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

use super::slabs::Slabs;

const WIDTH: usize = 8;
// Largest residual of a converged pair relative to its eigenvalue.
const TOLERANCE: f64 = 1e-8;
// Largest number of basis columns per eigenpair; two are usual.
const MOST: usize = 5;
// Further basis columns, because each of few eigenpairs needs more than `MOST`.
const SPARE: usize = 512;
const GROWTH: usize = 16;

struct Krylov {
    // Orthonormal columns; `len` and one more block are filled.
    basis: Slabs,
    // The projected operator, lower triangle.
    projected: Mat<f64>,
    len: usize,
    rng: Xoshiro256PlusPlus,
}

/// Computes the `n_pairs` largest eigenpairs, values descending; `apply` multiplies a block of columns in place.
pub fn largest_eigenpairs(n: usize, n_pairs: usize, apply: impl Fn(MatMut<'_, f64>)) -> Option<(Vec<f64>, Mat<f64>)> {
    let capacity = (MOST * n_pairs + SPARE).min(n.saturating_sub(WIDTH)) / WIDTH * WIDTH;
    let mut krylov = Krylov::new(n, capacity + WIDTH);
    let mut next_look = n_pairs + n_pairs / 2;
    while krylov.len < capacity {
        let last = krylov.step(&apply);
        // Converged pairs are searched only now and then, because the dense solve is expensive.
        if krylov.len >= next_look {
            if let Some(found) = krylov.ritz_pairs(n_pairs, last.as_ref()) {
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
        let basis = Slabs::zeros(n, GROWTH * WIDTH);
        let mut krylov = Self { basis, projected: Mat::zeros(capacity, capacity), len: 0, rng };
        krylov.push(Slabs::zeros(n, WIDTH));
        krylov
    }

    fn step(&mut self, apply: &impl Fn(MatMut<'_, f64>)) -> Mat<f64> {
        let (from, to) = (self.len, self.len + WIDTH);
        if self.basis.n_columns() < to + WIDTH {
            self.basis.widen(to + GROWTH * WIDTH);
        }
        let mut block = self.basis.columns(from..to).to_matrix();
        apply(block.as_mut());
        let mut block = Slabs::from_matrix(block.as_ref());
        self.len = to;
        // In exact arithmetic only the last two blocks matter; `push` removes rounding from the others.
        let near = from.saturating_sub(WIDTH);
        let inside = project_out(&self.basis, near..to, &mut block);
        self.projected.submatrix_mut(from, from, WIDTH, WIDTH).copy_from(inside.subrows(from - near, WIDTH));
        let link = self.push(block);
        self.projected.submatrix_mut(to, from, WIDTH, WIDTH).copy_from(&link);
        link
    }

    fn push(&mut self, mut block: Slabs) -> Mat<f64> {
        let first = self.orthonormalise(&mut block);
        project_out(&self.basis, 0..self.len, &mut block);
        let second = self.orthonormalise(&mut block);
        self.basis.put(self.len, &block);
        second * first
    }

    fn orthonormalise(&mut self, block: &mut Slabs) -> Mat<f64> {
        // The result is the triangle R of block = Q R.
        let mut triangle = Mat::zeros(WIDTH, WIDTH);
        for j in 0..WIDTH {
            let mut column = block.columns(j..j + 1);
            let before = length(&column);
            let mut inside = project_out(block, 0..j, &mut column);
            let left = length(&column);
            if left > 1e-10 * before {
                triangle[(j, j)] = left;
                inside += project_out(block, 0..j, &mut column);
            } else {
                // A dependent column is replaced by a random one.
                column = self.random_column();
                (0..2).for_each(|_| drop(project_out(block, 0..j, &mut column)));
            }
            triangle.submatrix_mut(0, j, j, 1).copy_from(inside);
            block.put(j, &column.combine(Mat::from_fn(1, 1, |_, _| 1.0 / length(&column)).as_ref()));
        }
        triangle
    }

    fn random_column(&mut self) -> Slabs {
        let uniform = |rng: &mut Xoshiro256PlusPlus| (rng.next_u64() >> 11) as f64 / (1u64 << 52) as f64 - 1.0;
        let column = Mat::from_fn(self.basis.n_rows(), 1, |_, _| uniform(&mut self.rng));
        let mut column = Slabs::from_matrix(column.as_ref());
        (0..2).for_each(|_| drop(project_out(&self.basis, 0..self.len, &mut column)));
        column
    }

    fn ritz_pairs(&self, n_pairs: usize, link: MatRef<'_, f64>) -> Option<(Vec<f64>, Mat<f64>)> {
        let projected = self.projected.submatrix(0, 0, self.len, self.len);
        let eigen = projected.self_adjoint_eigen(Side::Lower).ok()?;
        let values = eigen.S().column_vector();
        let largest = |i: usize| self.len - 1 - i;
        let is_found = |i: usize| {
            let end = eigen.U().submatrix(self.len - WIDTH, largest(i), WIDTH, 1);
            (link * end).norm_l2() <= TOLERANCE * values[largest(i)].abs()
        };
        if n_pairs > self.len || !(0..n_pairs).all(is_found) {
            return None;
        }
        let turned = Mat::from_fn(self.len, n_pairs, |row, i| eigen.U()[(row, largest(i))]);
        let vectors = self.basis.combine(turned.as_ref()).to_matrix();
        Some(((0..n_pairs).map(|i| values[largest(i)]).collect(), vectors))
    }
}

fn project_out(basis: &Slabs, columns: Range<usize>, block: &mut Slabs) -> Mat<f64> {
    let inside = basis.inner_products(columns.clone(), block);
    block.subtract(basis, columns, inside.as_ref());
    inside
}

fn length(column: &Slabs) -> f64 {
    column.inner_products(0..1, column)[(0, 0)].sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solve_diagonal(diagonal: &[f64], n_pairs: usize) -> (Vec<f64>, Mat<f64>) {
        let apply = |mut block: MatMut<'_, f64>| {
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
        assert!((gram - Mat::<f64>::identity(40, 40)).norm_max() < 1e-12);
    }

    #[test]
    fn values_that_are_several_times_there_are_found_as_often() {
        let diagonal: Vec<f64> = (0..900).map(|i| 1.0 / f64::from(1 + i / 7)).collect();
        let (values, _) = solve_diagonal(&diagonal, 63);
        assert!(values.iter().zip(&diagonal).all(|(a, b)| (a - b).abs() < 1e-12), "{values:?}");
    }
}
