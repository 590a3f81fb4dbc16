//! Training: data set, Adam, epochs, and checkpoints.
//!
//! A [`StepFunction`] computes each step; `objective` selects it. The caller decides when to write a checkpoint.

mod adam;
mod augment;
mod bending_step;
mod checkpoint;
mod csv_table;
mod data;
mod epochs;
mod error;
mod event;
mod face_terms;
mod loss_watch;
mod measured_step;
mod objective;
mod objectives;
mod paper_step;
mod patch;
pub mod random;
mod roughen;
mod run;
mod sampled_mesh;
mod sampler_terms;
mod scored_mesh;
mod settings;
mod step;
mod validation;
mod version;

pub use adam::{Moments, adam_step};
pub use data::{DataFile, DataSet, TrainingMesh, read_data};
pub use epochs::train;
pub use error::TrainError;
pub use event::{Ending, TrainEvent, Wish};
pub use measured_step::{Estimate, estimate_gradient};
pub use objective::{OBJECTIVES, OWN_OBJECTIVE, step_from_objective, step_function};
pub use objectives::{CustomObjective, ErrorShares, Errors, JudgedErrors, Objective, ShapeObjective};
pub use patch::cut_patch;
pub use run::{OUTPUT_FILES, OwnNetwork, TrainRequest, TrainingRun, open};
pub use settings::{DEFAULT_SETTINGS, Settings};
pub use step::{StepFunction, StepResult, TrainingItem, network_gradients, step_from_network};
pub use version::VERSION;
