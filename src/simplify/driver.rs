//! From the caller's mesh and options to results, whichever assembly makes them.

use crate::model::Weights;

use super::assemblies::{Sizes, Task, closed_levels, paper_result, unchanged};
use super::closed::{Closed, Derivative, is_sound};
use super::input::Input;
use super::limits::{resolve_levels, resolve_limit, resolve_oversample};
use super::options::{Assembly, Listener, Simplified, SimplifyError, Target};
use super::progress::{PAPER, Progress, closed_stages, listened};
use super::symmetric;
use super::used::Used;

/// One result, and how it depends on the positions, if that is asked for.
pub(super) fn run(
    input: &Input,
    weights: Option<&Weights>,
    task: &Task,
    listener: &mut Listener,
) -> Result<(Simplified, Option<Derivative>), SimplifyError> {
    let stages = match task.options.assembly {
        Assembly::Closed => closed_stages(1, task.options.symmetric.is_some()),
        Assembly::Paper => PAPER.to_vec(),
    };
    listened(listener, &stages, |progress| one(input, weights, task, progress))
}

fn one(
    input: &Input,
    weights: Option<&Weights>,
    task: &Task,
    progress: Progress,
) -> Result<(Simplified, Option<Derivative>), SimplifyError> {
    let options = task.options;
    input.check()?;
    if let Some(symmetry) = options.symmetric {
        let levels = symmetric::levels(input, weights, task, symmetry, &[options.target], progress)?;
        return Ok((levels.into_iter().next().ok_or(SimplifyError::Empty)?, None));
    }
    let is_closed = options.assembly == Assembly::Closed;
    if is_closed {
        progress.enter("surface", input.mesh.faces().len())?;
    }
    let used = Used::of(progress.pulse, input.mesh)?;
    let importance = input.importance_of(used.sources.as_deref());
    let input = Input { mesh: &used.mesh, importance: &importance, ..*input };
    let limit = resolve_limit(&used.mesh, options)?;
    let oversample = resolve_oversample(&used.mesh, limit, options)?;
    let is_done = limit.is_met_by(&used.mesh) && (!is_closed || is_sound(&used.mesh, &options.frame));
    let (simplified, derivative) = if is_done {
        (unchanged(progress.pulse, &input, options, oversample), None)
    } else if is_closed {
        let levels = closed_levels(&input, weights, task, &Sizes { limits: &[limit], oversample }, progress)?;
        levels.into_iter().next().map(Closed::into_result).ok_or(SimplifyError::Empty)?
    } else {
        (paper_result(&used.mesh, weights, options, limit, progress)?, None)
    };
    let derivative = derivative.map(|derivative| used.widen_derivative(derivative));
    Ok((used.widen(simplified), derivative))
}

/// Results of these sizes, each no larger than the one before.
pub(super) fn run_levels(
    input: &Input,
    weights: Option<&Weights>,
    task: &Task,
    targets: &[Target],
    listener: &mut Listener,
) -> Result<Vec<Simplified>, SimplifyError> {
    let stages = closed_stages(targets.len(), task.options.symmetric.is_some());
    listened(listener, &stages, |progress| several(input, weights, task, targets, progress))
}

fn several(
    input: &Input,
    weights: Option<&Weights>,
    task: &Task,
    targets: &[Target],
    progress: Progress,
) -> Result<Vec<Simplified>, SimplifyError> {
    let options = task.options;
    input.check()?;
    if let Some(symmetry) = options.symmetric {
        return symmetric::levels(input, weights, task, symmetry, targets, progress);
    }
    progress.enter("surface", input.mesh.faces().len())?;
    let used = Used::of(progress.pulse, input.mesh)?;
    let importance = input.importance_of(used.sources.as_deref());
    let input = Input { mesh: &used.mesh, importance: &importance, ..*input };
    let limits = resolve_levels(&used.mesh, targets, options)?;
    let oversample = resolve_oversample(&used.mesh, limits[0], options)?;
    // What is as large as the mesh is the mesh, as where there is one target.
    let n_met = limits.iter().take_while(|limit| limit.is_met_by(&used.mesh)).count();
    let n_unchanged = if n_met > 0 && is_sound(&used.mesh, &options.frame) { n_met } else { 0 };
    let same = (0..n_unchanged).map(|_| unchanged(progress.pulse, &input, options, oversample));
    let sizes = Sizes { limits: &limits[n_unchanged..], oversample };
    let lighter = closed_levels(&input, weights, task, &sizes, progress)?;
    let levels = same.chain(lighter.into_iter().map(|closed| closed.into_result().0));
    Ok(levels.map(|simplified| used.widen(simplified)).collect())
}
