//! neural-mesh for C: cbindgen makes `include/neural_mesh.h` from this package.
//!
//! [`indices`] has the functions of meshoptimizer, [`job`] whole jobs and [`clusters`] hierarchies of clusters by handle.
#![allow(unsafe_code, reason = "exported names, and functions that take pointers, are unsafe to declare")]

pub mod clusters;
pub mod errors;
pub mod indices;
pub mod job;
mod options;
mod pointers;

/// Number of this interface; it grows when functions change or go.
pub const NM_ABI_VERSION: u32 = 1;

/// Returns the interface number of the library, to be compared with `NM_ABI_VERSION`.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub extern "C" fn nm_abi_version() -> u32 {
    NM_ABI_VERSION
}
