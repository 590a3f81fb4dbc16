//! Training: a data set, Adam, epochs, and checkpoints from which a killed training goes on to the same bits.
//!
//! What one step learns is not known here: it is a [`StepFunction`], and `objective` chooses it. There is no clock
//! here either: the caller hears of every step and says when a checkpoint is due.

mod adam;
mod augment;
mod bending_step;
mod checkpoint;
mod data;
mod drawn;
mod epochs;
mod error;
mod event;
mod face_terms;
mod measured_step;
mod objective;
mod objectives;
mod paper_step;
mod patch;
pub mod random;
mod rows;
mod run;
mod sampler_terms;
mod scored;
mod settings;
mod step;
mod uniform_step;
mod validation;
mod version;
mod watch;

pub use adam::{Moments, adam_step};
pub use data::{DataFile, DataSet, Mesh, read_data};
pub use epochs::train;
pub use error::TrainError;
pub use event::{Ending, Event, Wish};
pub use measured_step::{Estimate, estimated};
pub use objective::{OBJECTIVES, OWN_OBJECTIVE, step_by, step_function};
pub use objectives::{Blame, Errors, Given, Objective, Shape, Verdict};
pub use patch::piece;
pub use run::{OwnNetwork, Request, Run, open};
pub use settings::{DEFAULT_SETTINGS, Settings};
pub use step::{Item, Step, StepFunction, gradients_of, of_network};
pub use version::VERSION;
