//! Eight numbers at a time, in the vectors of the processor that runs.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod dispatch;
mod eight;
#[cfg(not(all(target_arch = "wasm32", target_feature = "simd128")))]
mod plain;
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
mod simd128;

pub(crate) use dispatch::dispatch;
#[cfg(test)]
pub(crate) use dispatch::run_plain;
pub(crate) use eight::*;
