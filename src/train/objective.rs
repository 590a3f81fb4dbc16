//! Selection of the step function by the settings.

use super::bending_step::bending_step;
use super::measured_step::measured_step;
use super::paper_step::paper_step;
use super::{Objective, Settings, ShapeObjective, StepFunction, TrainError, step_from_network};

/// Value of the setting `objective` for a custom step.
pub const OWN_OBJECTIVE: &str = "own";

/// The values of the setting `objective`, with descriptions.
pub const OBJECTIVES: [(&str, &str); 3] = [
    ("bending", "scores for the closed assembly from the bending of the surface"),
    ("paper", "the paper's network with the paper's losses, for --assembly paper and mesh-points"),
    ("shape", "scores for the closed assembly from distance, normals and largest distance of results"),
];

/// Returns the step function named by the setting `objective`.
///
/// # Errors
/// [`TrainError::Settings`] if the name is unknown.
///
/// ```
/// use neural_mesh::train::{Settings, step_function};
/// assert!(step_function(&Settings::from_toml("objective = \"bending\"").unwrap()).is_ok());
/// assert!(step_function(&Settings::from_toml("objective = \"unheard of\"").unwrap()).is_err());
/// ```
pub fn step_function(settings: &Settings) -> Result<Box<StepFunction<'static>>, TrainError> {
    match settings.objective.as_str() {
        "bending" => Ok(step_from_network(bending_step)),
        "paper" => Ok(step_from_network(paper_step)),
        "shape" => Ok(step_from_objective(&ShapeObjective)),
        other => {
            let names = OBJECTIVES.map(|(name, _)| format!("\"{name}\"")).join(", ");
            Err(TrainError::Settings(format!("`objective` is \"{other}\": it must be one of {names}")))
        }
    }
}

/// Returns the step that learns the vertex importance for an objective.
///
/// ```
/// use neural_mesh::train::{ShapeObjective, step_from_objective};
/// let _step = step_from_objective(&ShapeObjective);
/// ```
pub fn step_from_objective<'a>(objective: &'a dyn Objective) -> Box<StepFunction<'a>> {
    step_from_network(|weights, item, settings, random| measured_step(objective, weights, item, settings, random))
}
