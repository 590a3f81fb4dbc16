//! Triangle meshes, their geometry and adjacency, trees over them, and matrices.
//!
//! Use it through `neural-mesh`, which has its modules under their names.

pub mod geometry;
pub mod linalg;
pub mod mesh;
pub mod parallel;
pub mod spatial;
