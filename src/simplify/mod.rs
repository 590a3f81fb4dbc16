//! The pipeline, Secs. 3 and 4: a mesh and a target in, a lighter mesh and its story out.

mod options;

pub use options::{Assembly, Event, Options, Outcome, Report, ScoreSource, Simplified, SimplifyError, Target};
