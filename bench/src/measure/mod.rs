//! Measures, and puts the tables into the pages of `docs/measured` and the README.

mod assets;
mod bench;
mod benchmark;
mod cgal;
mod curve;
mod figure6;
mod meshes;
mod pages;
mod paper;
mod performance;
mod pictures;
mod samplers;
mod textured;
mod versions;
mod weights;
mod whole;

pub use pages::{MeasureArgs, print_stale, run};
pub use whole::{MeshoptimizerArgs, run_meshoptimizer};
