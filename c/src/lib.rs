//! neural-mesh for C: cbindgen makes `include/neural_mesh.h` of this package.
//!
//! [`indices`] has the functions of meshoptimizer, [`job`] whole jobs by handle. [`errors`] keeps the last error of each thread and stops
//! panics; [`pointers`] is the one place where memory of the caller is read and written, and the one with `unsafe` blocks.
#![allow(unsafe_code, reason = "exported names, and functions that take pointers, are unsafe to declare")]

pub mod errors;
pub mod indices;
pub mod job;
mod options;
mod pointers;

/// Number of this interface; it grows where functions change or go.
pub const NM_ABI_VERSION: u32 = 1;

/// Returns the interface number of the library, which a program compares with `NM_ABI_VERSION`.
#[unsafe(no_mangle)]
pub extern "C" fn nm_abi_version() -> u32 {
    NM_ABI_VERSION
}
