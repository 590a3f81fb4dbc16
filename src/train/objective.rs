//! The one place where the settings choose what a step learns.

use super::bending_step::bending_step;
use super::closed_step::closed_step;
use super::paper_step::paper_step;
use super::uniform_step::uniform_step;
use super::{Settings, StepFunction, TrainError};

/// The step that the setting `objective` names.
///
/// # Errors
/// [`TrainError::Settings`] where there is none of that name.
///
/// ```
/// use neural_mesh::train::{Settings, step_function};
/// assert!(step_function(&Settings::from_toml("objective = \"uniform\"").unwrap()).is_ok());
/// assert!(step_function(&Settings::from_toml("objective = \"unheard of\"").unwrap()).is_err());
/// ```
pub fn step_function(settings: &Settings) -> Result<Box<StepFunction<'static>>, TrainError> {
    match settings.objective.as_str() {
        "bending" => Ok(Box::new(bending_step)),
        "closed" => Ok(Box::new(closed_step)),
        "paper" => Ok(Box::new(paper_step)),
        "uniform" => Ok(Box::new(uniform_step)),
        other => Err(TrainError::Settings(format!(
            "`objective` is \"{other}\": it must be \"bending\", \"closed\", \"paper\" or \"uniform\""
        ))),
    }
}
