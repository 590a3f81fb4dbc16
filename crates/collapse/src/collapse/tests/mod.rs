//! Tests of whole meshes, and what tests of kernels share.

pub(crate) mod measure;
pub(crate) mod meshes;
mod whole;
