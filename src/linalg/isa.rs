//! Which instructions this processor has, and rows of a result computed with them, in parallel.
//!
//! The one file with `unsafe`. Without run-time dispatch the kernels run about six times slower, because a
//! build for every x86-64 processor may only use SSE2. Why it is sound: a function compiled for instructions
//! that the processor lacks must not be called; an [`Isa`] other than the portable one is made only after
//! `is_x86_feature_detected!` has seen every feature that the matching function enables, and its field is
//! private. Where the compiler's own target has vectors and fused products (NEON), portable code has them too.
#![allow(unsafe_code)]

use super::{Csr, Matrix};
use rayon::prelude::*;
use std::ops::Range;

/// A set of instructions that this processor has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Isa(Level);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Level {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

/// Work that computes rows of a result, each row for itself.
pub(crate) trait RowKernel: Sync {
    /// Computes `rows` into `out`, which holds exactly those rows, zeroed. With `FMA` fused products are one
    /// instruction (otherwise a slow call). Must be `#[inline(always)]`, and so must the loops it calls: only
    /// what is inlined is compiled for the instructions at hand.
    fn compute<const FMA: bool>(&self, rows: Range<usize>, out: &mut [f32]);
}

/// Any work. Must be `#[inline(always)]`, and so must what it calls that is to be compiled for the instructions at hand.
pub(crate) trait Work {
    /// What it gives.
    type Output;

    /// Does it.
    fn run(self) -> Self::Output;
}

/// Columns that the kernels take at once where there are so many: loops of this fixed length over local arrays are
/// what the compiler turns into registers, with any vector length.
pub(crate) const WIDE: usize = 64;

/// Columns taken at once for what [`WIDE`] leaves.
pub(crate) const NARROW: usize = 16;

/// Work that computes a row of a result some columns at a time, so that sums stay in registers.
pub(crate) trait ColumnKernel: Sync {
    /// Number of columns of the result.
    fn width(&self) -> usize;

    /// Computes COLS columns of row `row` from `col` on into `out`, which holds exactly those, zeroed. Must be
    /// `#[inline(always)]`.
    fn columns<const COLS: usize, const FMA: bool>(&self, row: usize, col: usize, out: &mut [f32; COLS]);
}

impl<K: ColumnKernel> RowKernel for K {
    #[inline(always)]
    fn compute<const FMA: bool>(&self, rows: Range<usize>, out: &mut [f32]) {
        let width = self.width();
        for (row, out) in rows.zip(out.chunks_exact_mut(width.max(1))) {
            let (wide, rest) = out.as_chunks_mut::<WIDE>();
            for (i, out) in wide.iter_mut().enumerate() {
                self.columns::<WIDE, FMA>(row, i * WIDE, out);
            }
            let done = width - rest.len();
            let (narrow, rest) = rest.as_chunks_mut::<NARROW>();
            for (i, out) in narrow.iter_mut().enumerate() {
                self.columns::<NARROW, FMA>(row, done + i * NARROW, out);
            }
            let done = width - rest.len();
            for (i, out) in rest.as_chunks_mut::<1>().0.iter_mut().enumerate() {
                self.columns::<1, FMA>(row, done + i, out);
            }
        }
    }
}

/// Rows per task; fixed, so that nothing depends on the number of threads.
const BLOCK: usize = 64;

impl Isa {
    /// The best that this processor has.
    pub(crate) fn best() -> Self {
        #[cfg(test)]
        if let Some(forced) = super::golden::forced() {
            return forced;
        }
        Self::detected()
    }

    fn detected() -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512bw")
                && is_x86_feature_detected!("avx512dq")
                && is_x86_feature_detected!("avx512vl")
                && is_x86_feature_detected!("avx2")
                && is_x86_feature_detected!("fma")
            {
                return Self(Level::Avx512);
            }
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                return Self(Level::Avx2);
            }
        }
        Self(Level::Portable)
    }

    /// All that this processor has, for tests that compare them.
    #[cfg(test)]
    pub(crate) fn available() -> Vec<Self> {
        let best = Self::detected();
        #[cfg(target_arch = "x86_64")]
        if best == Self(Level::Avx512) {
            return vec![Self(Level::Portable), Self(Level::Avx2), best];
        }
        if best == Self(Level::Portable) { vec![best] } else { vec![Self(Level::Portable), best] }
    }

    /// Its name in the golden hashes.
    #[cfg(test)]
    pub(crate) fn name(self) -> &'static str {
        match self.0 {
            Level::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => "avx512",
        }
    }

    /// Does work compiled for these instructions.
    pub(crate) fn run<W: Work>(self, work: W) -> W::Output {
        match self.0 {
            Level::Portable => work.run(),
            // SAFETY: `self` exists, so the processor has the features (see the head of this file).
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => unsafe { run_avx2(work) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => unsafe { run_avx512(work) },
        }
    }

    fn compute<K: RowKernel>(self, kernel: &K, rows: Range<usize>, out: &mut [f32]) {
        match self.0 {
            Level::Portable => kernel.compute::<{ cfg!(target_feature = "neon") }>(rows, out),
            // SAFETY: `self` exists, so the processor has the features (see the head of this file).
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => unsafe { compute_avx2(kernel, rows, out) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => unsafe { compute_avx512(kernel, rows, out) },
        }
    }

    /// The matrix whose rows the kernel computes, rows in parallel.
    pub(crate) fn matrix<K: RowKernel>(self, kernel: &K, n_rows: usize, n_cols: usize) -> Matrix {
        let mut result = Matrix::zeros(n_rows, n_cols);
        let block = if n_cols > 1024 { 1 } else { BLOCK };
        result.data_mut().par_chunks_mut((block * n_cols).max(1)).enumerate().for_each(|(i, out)| {
            let begin = i * block;
            self.compute(kernel, begin..(begin + block).min(n_rows), out);
        });
        result
    }

    /// One value per entry of `pattern`, rows in parallel.
    pub(crate) fn entries<K: RowKernel>(self, kernel: &K, pattern: &Csr) -> Vec<f32> {
        let mut values = vec![0.0; pattern.n_entries()];
        let blocks = split_rows(pattern, &mut values);
        blocks.into_par_iter().for_each(|(rows, out)| self.compute(kernel, rows, out));
        values
    }
}

fn split_rows<'a>(pattern: &Csr, mut values: &'a mut [f32]) -> Vec<(Range<usize>, &'a mut [f32])> {
    let n_rows = pattern.n_rows();
    let mut blocks = Vec::with_capacity(n_rows.div_ceil(BLOCK));
    for begin in (0..n_rows).step_by(BLOCK) {
        let rows = begin..(begin + BLOCK).min(n_rows);
        let (head, tail) = values.split_at_mut(pattern.range_of_rows(rows.clone()).len());
        blocks.push((rows, head));
        values = tail;
    }
    blocks
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn compute_avx2<K: RowKernel>(kernel: &K, rows: Range<usize>, out: &mut [f32]) {
    kernel.compute::<true>(rows, out);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,fma")]
fn compute_avx512<K: RowKernel>(kernel: &K, rows: Range<usize>, out: &mut [f32]) {
    kernel.compute::<true>(rows, out);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn run_avx2<W: Work>(work: W) -> W::Output {
    work.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,fma")]
fn run_avx512<W: Work>(work: W) -> W::Output {
    work.run()
}

/// `a * b + c`, fused where that is one instruction.
#[inline(always)]
pub(crate) fn fused<const FMA: bool>(a: f32, b: f32, c: f32) -> f32 {
    if FMA { a.mul_add(b, c) } else { a * b + c }
}

/// `max(x, 0)`; a plain comparison, because `f32::max` costs three instructions for its care of NaN.
#[inline(always)]
pub(crate) fn relu(x: f32) -> f32 {
    if x > 0.0 { x } else { 0.0 }
}
