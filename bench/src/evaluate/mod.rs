//! Evaluation of methods on meshes at several ratios: rows, tables and charts, as in Sec. 4 of the paper.
//!
//! Methods are timed and have a time limit.

mod charts;
mod clock;
mod contest;
mod engine;
mod error;
mod folder;
mod foreign;
mod hardware;
mod job;
mod limited;
mod meshes;
mod method;
mod overview;
mod rehearsal;
mod report;
mod row;
mod rows_file;
mod run;
mod settings;
mod summary;
mod tables;
mod tool;
mod worst;

pub use charts::{Chart, MethodLine, charts};
pub use engine::Worker;
pub use error::EvaluateError;
pub use job::answer_job;
pub use method::Method;
pub use overview::{Column, Failures, FigureSummary, MethodSummary, Overview, Points, overview, points};
pub use report::write_report;
pub use row::{Conditions, ResultRow};
pub use rows_file::Table;
pub use run::{Ending, Event, Request, evaluate, median};
pub use settings::Settings;
pub use summary::Facts;
pub use tool::Tool;
pub use worst::{WorstCase, worst_cases};
