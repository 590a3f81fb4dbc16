//! A tall matrix in slabs of rows: products run in parallel, sums in a fixed order.

use std::ops::Range;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use rayon::prelude::*;

// Number of rows of a slab, which then fits the nearest cache.
const ROWS: usize = 1024;

pub struct Slabs {
    slabs: Vec<Mat<f64>>,
}

impl Slabs {
    pub fn zeros(n: usize, n_columns: usize) -> Self {
        let rows = |start: usize| ROWS.min(n - start);
        Self { slabs: (0..n).step_by(ROWS).map(|start| Mat::zeros(rows(start), n_columns)).collect() }
    }

    pub fn from_matrix(whole: MatRef<'_, f64>) -> Self {
        let mut slabs = Self::zeros(whole.nrows(), whole.ncols());
        let numbered = slabs.slabs.par_iter_mut().enumerate();
        numbered.for_each(|(at, slab)| slab.copy_from(whole.subrows(at * ROWS, slab.nrows())));
        slabs
    }

    pub fn to_matrix(&self) -> Mat<f64> {
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

    pub fn widen(&mut self, n_columns: usize) {
        self.slabs.par_iter_mut().for_each(|slab| slab.resize_with(slab.nrows(), n_columns, |_, _| 0.0));
    }

    pub fn columns(&self, columns: Range<usize>) -> Self {
        Self {
            slabs: self.slabs.par_iter().map(|slab| slab.subcols(columns.start, columns.len()).to_owned()).collect(),
        }
    }

    pub fn put(&mut self, start: usize, other: &Self) {
        let both = self.slabs.par_iter_mut().zip(&other.slabs);
        both.for_each(|(slab, other)| slab.subcols_mut(start, other.ncols()).copy_from(other));
    }

    pub fn inner_products(&self, columns: Range<usize>, other: &Self) -> Mat<f64> {
        let product = |(slab, other): (&Mat<f64>, &Mat<f64>)| {
            let mut part = Mat::zeros(columns.len(), other.ncols());
            let transposed = slab.subcols(columns.start, columns.len()).transpose();
            matmul(&mut part, Accum::Replace, transposed, other, 1.0, Par::Seq);
            part
        };
        let parts: Vec<Mat<f64>> = self.slabs.par_iter().zip(&other.slabs).map(product).collect();
        parts.into_iter().fold(Mat::zeros(columns.len(), other.n_columns()), |sum, part| sum + part)
    }

    pub fn subtract(&mut self, basis: &Self, columns: Range<usize>, shares: MatRef<'_, f64>) {
        let both = self.slabs.par_iter_mut().zip(&basis.slabs);
        both.for_each(|(slab, basis)| {
            matmul(slab, Accum::Add, basis.subcols(columns.start, columns.len()), shares, -1.0, Par::Seq);
        });
    }

    pub fn combine(&self, shares: MatRef<'_, f64>) -> Self {
        let mixed = |slab: &Mat<f64>| slab.subcols(0, shares.nrows()) * shares;
        Self { slabs: self.slabs.par_iter().map(mixed).collect() }
    }
}
