//! A tall matrix in slabs of rows: products run in parallel, sums in a fixed order.

use neural_mesh::parallel;
use std::ops::Range;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};

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
        parallel::change(&mut slabs.slabs, 1, |at, slab| slab.copy_from(whole.subrows(at * ROWS, slab.nrows())));
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
        parallel::change(&mut self.slabs, 1, |_, slab| slab.resize_with(slab.nrows(), n_columns, |_, _| 0.0));
    }

    pub fn columns(&self, columns: Range<usize>) -> Self {
        let some = |slab: &Mat<f64>| slab.subcols(columns.start, columns.len()).to_owned();
        Self { slabs: parallel::each(&self.slabs, some) }
    }

    pub fn put(&mut self, start: usize, other: &Self) {
        parallel::change(&mut self.slabs, 1, |at, slab| {
            let other = &other.slabs[at];
            slab.subcols_mut(start, other.ncols()).copy_from(other);
        });
    }

    pub fn inner_products(&self, columns: Range<usize>, other: &Self) -> Mat<f64> {
        let product = |(slab, other): (&Mat<f64>, &Mat<f64>)| {
            let mut part = Mat::zeros(columns.len(), other.ncols());
            let transposed = slab.subcols(columns.start, columns.len()).transpose();
            matmul(&mut part, Accum::Replace, transposed, other, 1.0, Par::Seq);
            part
        };
        let parts = parallel::each(self.slabs.iter().zip(&other.slabs), product);
        parts.into_iter().fold(Mat::zeros(columns.len(), other.n_columns()), |sum, part| sum + part)
    }

    pub fn subtract(&mut self, basis: &Self, columns: Range<usize>, shares: MatRef<'_, f64>) {
        parallel::change(&mut self.slabs, 1, |at, slab| {
            matmul(slab, Accum::Add, basis.slabs[at].subcols(columns.start, columns.len()), shares, -1.0, Par::Seq);
        });
    }

    pub fn combine(&self, shares: MatRef<'_, f64>) -> Self {
        let mixed = |slab: &Mat<f64>| slab.subcols(0, shares.nrows()) * shares;
        Self { slabs: parallel::each(&self.slabs, mixed) }
    }
}
