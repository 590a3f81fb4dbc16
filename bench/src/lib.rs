//! Measures neural-mesh and other methods, and makes the pages of `docs/measured`.

pub mod along_surface;
#[cfg(test)]
mod autodiff;
pub mod baselines;
mod cells;
mod clock;
mod command;
mod evaluate;
mod learned_baselines;
#[cfg(test)]
mod linalg;
mod measure;
mod rows;
mod rows_file;
mod tables;

pub use command::run;
