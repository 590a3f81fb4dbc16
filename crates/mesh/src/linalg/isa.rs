//! Instruction sets of the processor, and kernels that compute rows of a result with them, in parallel.
//!
//! The one file with `unsafe`: portable kernels are about six times slower. The `unsafe` code is sound: an [`Isa`]
//! other than the portable one is made only after `is_x86_feature_detected!` has found every feature that the matching
//! function enables.
#![allow(unsafe_code)]

use super::{Csr, Matrix};
use crate::parallel;
use std::ops::Range;

/// A set of instructions that this processor has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[doc(hidden)]
pub struct Isa(IsaLevel);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum IsaLevel {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2,
}

pub(crate) trait RowKernel: Sync {
    /// Computes `rows` into `out`, which holds exactly those rows, zeroed.
    ///
    /// `FMA` is true if a fused product is one instruction. Implementations and callees must be `#[inline(always)]`,
    /// since only inlined code is compiled for the chosen instructions.
    fn compute<const FMA: bool>(&self, rows: Range<usize>, out: &mut [f32]);
}

/// A task to compile for each instruction set; it and its callees must be `#[inline(always)]`.
#[doc(hidden)]
pub trait Work {
    type Output;

    fn run(self) -> Self::Output;
}

/// Columns per step in wide results; local arrays of this length stay in registers.
pub(crate) const WIDE: usize = 64;

/// Columns per step in the remainder of [`WIDE`].
pub(crate) const NARROW: usize = 16;

/// A kernel that computes some columns of a row at a time.
pub(crate) trait ColumnKernel: Sync {
    fn width(&self) -> usize;

    /// Computes COLS columns of `row` from `col` on into `out`, zeroed; must be `#[inline(always)]`.
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

const BLOCK: usize = 64;

#[cfg(test)]
thread_local! {
    static FORCED: std::cell::Cell<Option<Isa>> = const { std::cell::Cell::new(None) };
}

impl Isa {
    #[doc(hidden)]
    pub fn best() -> Self {
        #[cfg(test)]
        if let Some(forced) = FORCED.get() {
            return forced;
        }
        #[cfg(any(test, feature = "test-support"))]
        if let Some(forced) = super::golden::forced_isa() {
            return forced;
        }
        Self::detect()
    }

    fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            return Self(IsaLevel::Avx2);
        }
        Self(IsaLevel::Portable)
    }

    #[cfg(any(test, feature = "test-support"))]
    #[doc(hidden)]
    pub fn available() -> Vec<Self> {
        let best = Self::detect();
        if best == Self(IsaLevel::Portable) { vec![best] } else { vec![Self(IsaLevel::Portable), best] }
    }

    /// Runs a test with each instruction set of the processor.
    #[cfg(test)]
    pub(crate) fn on_each(test: impl Fn()) {
        for isa in Self::available() {
            FORCED.set(Some(isa));
            test();
        }
        FORCED.set(None);
    }

    #[cfg(any(test, feature = "test-support"))]
    #[doc(hidden)]
    pub fn name(self) -> &'static str {
        match self.0 {
            IsaLevel::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            IsaLevel::Avx2 => "avx2",
        }
    }

    #[doc(hidden)]
    pub fn run<W: Work>(self, work: W) -> W::Output {
        match self.0 {
            IsaLevel::Portable => work.run(),
            // SAFETY: `self` exists, so the processor has the features (see the head of this file).
            #[cfg(target_arch = "x86_64")]
            IsaLevel::Avx2 => unsafe { run_avx2(work) },
        }
    }

    fn compute<K: RowKernel>(self, kernel: &K, rows: Range<usize>, out: &mut [f32]) {
        match self.0 {
            IsaLevel::Portable => kernel.compute::<{ cfg!(target_feature = "neon") }>(rows, out),
            // SAFETY: `self` exists, so the processor has the features (see the head of this file).
            #[cfg(target_arch = "x86_64")]
            IsaLevel::Avx2 => unsafe { compute_avx2(kernel, rows, out) },
        }
    }

    pub(crate) fn compute_matrix<K: RowKernel>(self, kernel: &K, n_rows: usize, n_cols: usize) -> Matrix {
        let mut result = Matrix::zeros(n_rows, n_cols);
        let block = if n_cols > 1024 { 1 } else { BLOCK };
        parallel::chunks_mut(result.data_mut(), (block * n_cols).max(1), |i, out| {
            let begin = i * block;
            self.compute(kernel, begin..(begin + block).min(n_rows), out);
        });
        result
    }

    pub(crate) fn compute_entries<K: RowKernel>(self, kernel: &K, pattern: &Csr) -> Vec<f32> {
        let mut values = vec![0.0; pattern.n_entries()];
        let blocks = pattern.split_rows(BLOCK, &mut values);
        parallel::each(blocks, |(rows, out)| self.compute(kernel, rows, out));
        values
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn compute_avx2<K: RowKernel>(kernel: &K, rows: Range<usize>, out: &mut [f32]) {
    kernel.compute::<true>(rows, out);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn run_avx2<W: Work>(work: W) -> W::Output {
    work.run()
}

/// Returns `a * b + c`, fused if that is one instruction.
#[inline(always)]
pub(crate) fn multiply_add<const FMA: bool>(a: f32, b: f32, c: f32) -> f32 {
    if FMA { a.mul_add(b, c) } else { a * b + c }
}

/// Returns `max(x, 0)`; `f32::max` takes three instructions because of NaN.
#[inline(always)]
#[doc(hidden)]
pub fn relu(x: f32) -> f32 {
    if x > 0.0 { x } else { 0.0 }
}
