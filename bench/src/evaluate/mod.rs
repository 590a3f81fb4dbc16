//! Methods x sizes x meshes -> rows, tables and what is plotted of them: the paper's Sec. 4 for any method.
//!
//! Methods are timed, and those that hang are killed.

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

pub use charts::{Chart, Line, charts};
pub use engine::Worker;
pub use error::EvaluateError;
pub use job::answer;
pub use method::Method;
pub use overview::{Cell, Column, Failures, Overview, Points, Standing, overview, points};
pub use report::report;
pub use row::{How, Row};
pub use rows_file::Table;
pub use run::{Ending, Event, Request, evaluate, median};
pub use settings::Settings;
pub use summary::Facts;
pub use tool::Tool;
pub use worst::{Worst, worst};
