//! Index buffers for C, by the kernel alone: cbindgen makes `include/neural_mesh_core.h` from this package.
//!
//! [`indices`] has the functions of meshoptimizer that simplify, [`pool`] threads that stay between calls.
#![allow(unsafe_code, reason = "exported names, and functions that take pointers, are unsafe to declare")]

pub mod errors;
pub mod indices;
pub mod pointers;
pub mod pool;
