//! Evaluation of methods on meshes at several ratios, as in Sec. 4 of the paper.

mod clock;
mod contest;
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

pub use crate::error::EvaluateError;
pub(crate) use clock::thread_time;
pub use engine::Worker;
pub use job::answer_job;
pub(crate) use meshes::mesh_files;
pub use report::{REPORT, write_report};
pub use run::{Ending, Event, Request, evaluate};
pub use settings::Settings;
pub use tool::Tool;
