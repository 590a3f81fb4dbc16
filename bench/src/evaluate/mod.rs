//! Evaluation of methods on meshes at several ratios, as in Sec. 4 of the paper.

mod engine;
mod folder;
mod foreign;
mod job;
mod limited;
mod meshes;
mod method;
mod report;
mod run;
mod settings;
mod tool;

pub use job::{answer_job, simplify_ours};
pub(crate) use meshes::mesh_files;
pub use report::{REPORT, write_report};
pub use run::evaluate;
pub use settings::{EvaluateOptions, Settings};
pub use tool::Tool;
