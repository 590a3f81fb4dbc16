//! The largest eigenpairs of a symmetric operator by block Lanczos with full reorthogonalisation.
//!
//! After Golub and Underwood, "The block Lanczos method for computing eigenvalues" (1977). A block finds eigenvalues that
//! are several times there, up to its width and usually beyond.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par, Side};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

/// Columns of a block.
const WIDTH: usize = 8;
/// How far `A x` may be from `theta x`, as a share of theta, for an eigenpair to count as found.
const TOLERANCE: f64 = 1e-8;
/// Columns of the basis per eigenpair, at most; two are usual,
const MOST: usize = 5;
/// and columns beside, as few eigenpairs need more each.
const SPARE: usize = 512;
/// Blocks that the basis begins with, and grows by when it is full.
const GROWTH: usize = 16;

/// The basis so far and the operator seen in it.
struct Krylov {
    /// Orthonormal columns, n rows; the first `len` and the block after them are filled, what follows is zero.
    basis: Mat<f64>,
    /// The operator in the basis, lower triangle, capacity x capacity.
    seen: Mat<f64>,
    len: usize,
    rng: Xoshiro256PlusPlus,
}

/// The `n_pairs` largest eigenvalues, descending, and orthonormal eigenvectors as columns, n x n_pairs.
///
/// `apply` puts the operator's products in the place of a block of columns of length `n`. `None` where the basis would
/// have to be larger than a bound or than the space.
pub fn largest(n: usize, n_pairs: usize, apply: impl Fn(MatMut<'_, f64>)) -> Option<(Vec<f64>, Mat<f64>)> {
    let capacity = (MOST * n_pairs + SPARE).min(n.saturating_sub(WIDTH)) / WIDTH * WIDTH;
    let mut krylov = Krylov::new(n, capacity + WIDTH);
    let mut next_look = n_pairs + n_pairs / 2;
    while krylov.len < capacity {
        let last = krylov.step(&apply);
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
        let basis = Mat::zeros(n, GROWTH * WIDTH);
        let mut krylov = Self { basis, seen: Mat::zeros(capacity, capacity), len: 0, rng };
        krylov.push(&Mat::zeros(n, WIDTH));
        krylov
    }

    /// Adds the last block to the basis and the next one after it; returns the triangle that links the two.
    fn step(&mut self, apply: &impl Fn(MatMut<'_, f64>)) -> Mat<f64> {
        let (from, to) = (self.len, self.len + WIDTH);
        if self.basis.ncols() < to + WIDTH {
            self.basis.resize_with(self.basis.nrows(), to + GROWTH * WIDTH, |_, _| 0.0);
        }
        let mut block = self.basis.subcols(from, WIDTH).to_owned();
        apply(block.as_mut());
        self.len = to;
        // In exact arithmetic only the last two blocks matter; the second pass takes out what rounding has left.
        let near = from.saturating_sub(WIDTH);
        let mut inside = Mat::zeros(to, WIDTH);
        inside.subrows_mut(near, to - near).copy_from(project_out(self.basis.subcols(near, to - near), &mut block));
        inside += project_out(self.basis.subcols(0, to), &mut block);
        self.seen.submatrix_mut(from, from, WIDTH, WIDTH).copy_from(inside.subrows(from, WIDTH));
        let link = self.push(&block);
        self.seen.submatrix_mut(to, from, WIDTH, WIDTH).copy_from(&link);
        link
    }

    /// Orthonormalises the columns of a block and puts them after the basis; returns the triangle R of block = Q R.
    fn push(&mut self, block: &Mat<f64>) -> Mat<f64> {
        let mut triangle = Mat::zeros(WIDTH, WIDTH);
        for j in 0..WIDTH {
            let mut column = block.subcols(j, 1).to_owned();
            let before = column.norm_l2();
            let others = self.basis.subcols(self.len, j);
            let inside = project_out(others, &mut column);
            let left = column.norm_l2();
            triangle.submatrix_mut(0, j, j, 1).copy_from(inside);
            if left > 1e-10 * before {
                triangle[(j, j)] = left;
                project_out(self.basis.subcols(0, self.len + j), &mut column);
            } else {
                // Nothing new lies in this direction: any other will do.
                column = self.random_column();
            }
            let length = column.norm_l2();
            self.basis.col_mut(self.len + j).copy_from(column.col(0) * faer::Scale(1.0 / length));
        }
        triangle
    }

    /// A direction orthogonal to all columns filled so far; those not yet filled are zero and do no harm.
    fn random_column(&mut self) -> Mat<f64> {
        let uniform = |rng: &mut Xoshiro256PlusPlus| (rng.next_u64() >> 11) as f64 / (1u64 << 52) as f64 - 1.0;
        let mut column = Mat::from_fn(self.basis.nrows(), 1, |_, _| uniform(&mut self.rng));
        for _ in 0..2 {
            project_out(self.basis.as_ref(), &mut column);
        }
        column
    }

    /// The largest eigenpairs, once all of them are accurate.
    fn ritz_pairs(&self, n_pairs: usize, link: MatRef<'_, f64>) -> Option<(Vec<f64>, Mat<f64>)> {
        let seen = self.seen.submatrix(0, 0, self.len, self.len);
        let eigen = seen.self_adjoint_eigen(Side::Lower).ok()?;
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
        let mut vectors = Mat::zeros(self.basis.nrows(), n_pairs);
        matmul(&mut vectors, Accum::Replace, self.basis.subcols(0, self.len), &turned, 1.0, Par::Seq);
        Some(((0..n_pairs).map(|i| values[largest(i)]).collect(), vectors))
    }
}

/// Takes from the columns of `block` what lies in the span of the orthonormal columns `basis`, and returns it in that basis.
fn project_out(basis: MatRef<'_, f64>, block: &mut Mat<f64>) -> Mat<f64> {
    let mut inside = Mat::zeros(basis.ncols(), block.ncols());
    matmul(&mut inside, Accum::Replace, basis.transpose(), &*block, 1.0, Par::Seq);
    matmul(block, Accum::Add, basis, &inside, -1.0, Par::Seq);
    inside
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of_diagonal(diagonal: &[f64], n_pairs: usize) -> (Vec<f64>, Mat<f64>) {
        let apply = |mut block: MatMut<'_, f64>| {
            for j in 0..block.ncols() {
                (0..block.nrows()).for_each(|i| block[(i, j)] *= diagonal[i]);
            }
        };
        largest(diagonal.len(), n_pairs, apply).unwrap()
    }

    #[test]
    fn the_largest_of_a_diagonal_are_its_largest() {
        let diagonal: Vec<f64> = (1..=900).map(|i| 1.0 / f64::from(i)).collect();
        let (values, vectors) = of_diagonal(&diagonal, 40);
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
        let (values, _) = of_diagonal(&diagonal, 63);
        assert!(values.iter().zip(&diagonal).all(|(a, b)| (a - b).abs() < 1e-12), "{values:?}");
    }
}
