//! Eight numbers at a time, in the vectors of the processor that runs.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod dispatch;
mod eight;
mod plain;

pub(crate) use dispatch::dispatch;
#[cfg(test)]
pub(crate) use dispatch::run_plain;
pub(crate) use eight::*;
