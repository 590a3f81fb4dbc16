//! Measures neural-mesh and other methods, and makes the pages of `docs/measured`.

pub mod along_surface;
#[cfg(test)]
mod autodiff;
mod axis_range;
pub mod baselines;
#[cfg(test)]
#[path = "../../cli/tests/common/page_check.rs"]
mod check_page;
mod command;
pub mod evaluate;
pub mod learned_baselines;
#[cfg(test)]
mod linalg;
mod measure;

pub use command::run;
