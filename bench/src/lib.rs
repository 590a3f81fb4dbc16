//! Measures neural-mesh and methods of others: evaluations of any method on any meshes, and the pages of `docs/measured`. Never
//! published.

#[cfg(test)]
#[path = "../../cli/src/page/check.rs"]
mod check_page;
mod command;
pub mod evaluate;
mod measure;

pub use command::run;
