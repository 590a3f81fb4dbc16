//! Index buffers for C, by the kernel alone: cbindgen makes `include/neural_mesh_core.h` from this package.
//!
//! [`indices`] has the functions of meshoptimizer that simplify, [`pool`] threads that stay between calls, [`allocator`] the
//! caller's memory.
#![allow(unsafe_code, reason = "exported names, and functions that take pointers, are unsafe to declare")]

pub mod allocator;
pub mod errors;
pub mod indices;
pub mod pointers;
pub mod pool;

/// Number of this interface; it grows when functions change or go.
pub const NM_ABI_VERSION: u32 = 1;

/// Returns the interface number of the library, to be compared with `NM_ABI_VERSION`.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub extern "C" fn nm_abi_version() -> u32 {
    NM_ABI_VERSION
}
