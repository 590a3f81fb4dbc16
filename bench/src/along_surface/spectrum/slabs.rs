//! A tall matrix cut into slabs of rows: products over it run on all threads, and sums over slabs are taken in one order,
//! so that threads change no bit.

use std::ops::Range;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use rayon::prelude::*;

/// Rows of a slab: a slab of a block stays in the nearest cache.
const ROWS: usize = 1024;

/// A matrix of n rows, each slab of them with memory of its own.
pub struct Slabs {
    slabs: Vec<Mat<f64>>,
}

impl Slabs {
    /// All zero, n x n_columns.
    pub fn zeros(n: usize, n_columns: usize) -> Self {
        let rows = |start: usize| ROWS.min(n - start);
        Self { slabs: (0..n).step_by(ROWS).map(|start| Mat::zeros(rows(start), n_columns)).collect() }
    }

    /// Cuts a matrix.
    pub fn of(whole: MatRef<'_, f64>) -> Self {
        let mut slabs = Self::zeros(whole.nrows(), whole.ncols());
        slabs.each(|rows, slab| slab.copy_from(whole.subrows(rows.start, rows.len())));
        slabs
    }

    /// Puts the slabs together again: n x n_columns.
    pub fn whole(&self) -> Mat<f64> {
        let mut whole = Mat::zeros(self.n_rows(), self.n_columns());
        let mut rest = whole.as_mut();
        for slab in &self.slabs {
            let (mut rows, below) = rest.split_at_row_mut(slab.nrows());
            rows.copy_from(slab);
            rest = below;
        }
        whole
    }

    pub fn n_rows(&self) -> usize {
        self.slabs.iter().map(Mat::nrows).sum()
    }

    pub fn n_columns(&self) -> usize {
        self.slabs.first().map_or(0, Mat::ncols)
    }

    /// Adds columns of zeros.
    pub fn widen(&mut self, n_columns: usize) {
        self.slabs.par_iter_mut().for_each(|slab| slab.resize_with(slab.nrows(), n_columns, |_, _| 0.0));
    }

    /// Some of the columns.
    pub fn columns(&self, columns: Range<usize>) -> Self {
        Self {
            slabs: self.slabs.par_iter().map(|slab| slab.subcols(columns.start, columns.len()).to_owned()).collect(),
        }
    }

    /// Puts the columns of another in the place of those from `start` on.
    pub fn put(&mut self, start: usize, other: &Self) {
        let both = self.slabs.par_iter_mut().zip(&other.slabs);
        both.for_each(|(slab, other)| slab.subcols_mut(start, other.ncols()).copy_from(other));
    }

    /// Inner products of some columns (rows of the result) with those of another.
    pub fn inner(&self, columns: Range<usize>, other: &Self) -> Mat<f64> {
        let product = |(slab, other): (&Mat<f64>, &Mat<f64>)| {
            let mut part = Mat::zeros(columns.len(), other.ncols());
            let transposed = slab.subcols(columns.start, columns.len()).transpose();
            matmul(&mut part, Accum::Replace, transposed, other, 1.0, Par::Seq);
            part
        };
        let parts: Vec<Mat<f64>> = self.slabs.par_iter().zip(&other.slabs).map(product).collect();
        parts.into_iter().fold(Mat::zeros(columns.len(), other.n_columns()), |sum, part| sum + part)
    }

    /// Takes from each column what some columns of `basis` make up in these shares, columns x own columns.
    pub fn subtract(&mut self, basis: &Self, columns: Range<usize>, shares: MatRef<'_, f64>) {
        let both = self.slabs.par_iter_mut().zip(&basis.slabs);
        both.for_each(|(slab, basis)| {
            matmul(slab, Accum::Add, basis.subcols(columns.start, columns.len()), shares, -1.0, Par::Seq);
        });
    }

    /// What the first columns make up in these shares: n x columns of the shares.
    pub fn mixed(&self, shares: MatRef<'_, f64>) -> Self {
        let mixed = |slab: &Mat<f64>| slab.subcols(0, shares.nrows()) * shares;
        Self { slabs: self.slabs.par_iter().map(mixed).collect() }
    }

    fn each(&mut self, work: impl Fn(Range<usize>, &mut MatMut<'_, f64>) + Sync) {
        let numbered = self.slabs.par_iter_mut().enumerate();
        numbered.for_each(|(at, slab)| work(at * ROWS..at * ROWS + slab.nrows(), &mut slab.as_mut()));
    }
}
