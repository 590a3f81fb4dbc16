//! neural-mesh for C: cbindgen makes `include/neural_mesh.h` from this package.
//!
//! [`job`] has whole jobs and [`clusters`] hierarchies of clusters by handle; functions for index buffers, errors and
//! memory are those of `neural-mesh-core`, whose header this one includes.
#![allow(unsafe_code, reason = "exported names, and functions that take pointers, are unsafe to declare")]

pub mod clusters;
pub mod job;
mod options;

use neural_mesh_core::pointers;
pub use neural_mesh_core::{allocator, errors, indices, pool};
