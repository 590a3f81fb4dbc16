//! The one place where the settings choose what a step learns.

use super::bending_step::bending_step;
use super::measured_step::measured_step;
use super::paper_step::paper_step;
use super::uniform_step::uniform_step;
use super::{Objective, Settings, Shape, StepFunction, TrainError, of_network};

/// What the setting `objective` is called where the step is one's own, by [`step_by`].
pub const OWN_OBJECTIVE: &str = "own";

/// What the setting `objective` may be called, and what each learns.
pub const OBJECTIVES: [(&str, &str); 4] = [
    ("bending", "how much the surface bends: scores for the closed assembly"),
    ("paper", "the paper's network by its losses, for --assembly paper and mesh-points"),
    ("shape", "distance, normals and largest distance of results: scores for the closed assembly"),
    ("uniform", "equal scores, which try out a machine and a data set"),
];

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
        "bending" => Ok(of_network(bending_step)),
        "paper" => Ok(of_network(paper_step)),
        "shape" => Ok(step_by(&Shape)),
        "uniform" => Ok(of_network(uniform_step)),
        other => {
            let names = OBJECTIVES.map(|(name, _)| format!("\"{name}\"")).join(", ");
            Err(TrainError::Settings(format!("`objective` is \"{other}\": it must be one of {names}")))
        }
    }
}

/// The step that learns which importance of the vertices makes an objective of the closed assembly's results smallest.
///
/// ```
/// use neural_mesh::train::{Shape, step_by};
/// let _step = step_by(&Shape);
/// ```
pub fn step_by<'a>(objective: &'a dyn Objective) -> Box<StepFunction<'a>> {
    of_network(|weights, item, settings, random| measured_step(objective, weights, item, settings, random))
}
