//! Driver of both assemblies: from the caller's mesh and options to results.

use crate::model::Weights;

use super::assemblies::{TargetSizes, Task, pruned_result, simplify_by_paper, simplify_closed, unchanged_result};
use super::closed::{Derivative, is_sound};
use super::input::Input;
use super::limits::{Limit, resolve_levels, resolve_limit};
use super::options::{Assembly, Listener, Options, PaperOptions, ScoreSource, Simplified, SimplifyError, Target};
use super::progress::{PAPER_STAGES, Progress, closed_stages, run_with_listener};
use super::symmetric;
use super::used_mesh::UsedMesh;

type TracedResult = (Simplified, Option<Derivative>);

pub(super) fn run(
    input: &Input,
    weights: Option<&Weights>,
    options: &Options,
    differentiable: bool,
    listener: &mut Listener,
) -> Result<TracedResult, SimplifyError> {
    match &options.assembly {
        Assembly::Closed(closed) => {
            run_closed_to(input, weights, &Task { differentiable, ..Task::new(closed) }, options.target, listener)
        }
        Assembly::Paper(paper) => run_with_listener(listener, &PAPER_STAGES, |progress| {
            Ok((run_paper(input, weights, paper, options.target, progress)?, None))
        }),
    }
}

pub(super) fn run_closed_to(
    input: &Input,
    weights: Option<&Weights>,
    task: &Task,
    target: Target,
    listener: &mut Listener,
) -> Result<TracedResult, SimplifyError> {
    let levels = run_levels(input, weights, task, &[target], listener)?;
    levels.into_iter().next().ok_or(SimplifyError::Empty)
}

pub(super) fn run_levels(
    input: &Input,
    weights: Option<&Weights>,
    task: &Task,
    targets: &[Target],
    listener: &mut Listener,
) -> Result<Vec<TracedResult>, SimplifyError> {
    // Stages take shares of time that depend on the size of the first level.
    let share = targets.first().map_or(1.0, |target| target.share_of(input.mesh));
    let stages = closed_stages(targets.len(), task.options.symmetric.is_some(), share);
    run_with_listener(listener, &stages, |progress| run_closed(input, weights, task, targets, progress))
}

fn run_closed(
    input: &Input,
    weights: Option<&Weights>,
    task: &Task,
    targets: &[Target],
    progress: Progress,
) -> Result<Vec<TracedResult>, SimplifyError> {
    let options = task.options;
    input.check()?;
    if let Some(symmetry) = options.symmetric {
        let levels = symmetric::simplify_symmetric(input, weights, task, symmetry, targets, progress)?;
        return Ok(levels.into_iter().map(|level| (level, None)).collect());
    }
    progress.enter("surface", input.mesh.faces().len())?;
    // Unused vertices are removed first and restored in the results.
    let used = UsedMesh::new(progress.pulse, input.mesh)?;
    let importance = input.select_importance(used.sources.as_deref());
    let locked = input.select_locked(used.sources.as_deref());
    let input = Input { mesh: &used.mesh, importance: &importance, locked: &locked, ..*input };
    let mut limits = resolve_levels(&used.mesh, targets)?;
    // A target at or above the input size returns the input.
    let n_met = limits.iter().take_while(|limit| limit.is_met_by(&used.mesh)).count();
    let n_unchanged = if n_met > 0 && is_sound(&used.mesh, &options.frame) { n_met } else { 0 };
    // Repairs of an unsound mesh split vertices; none is then merged away to make up for them.
    limits[n_unchanged..n_met.max(n_unchanged)].fill(Limit::NONE);
    let unchanged = || Ok((pruned_result(progress.pulse, &input, options)?, None));
    let unchanged: Vec<TracedResult> = (0..n_unchanged).map(|_| unchanged()).collect::<Result<_, _>>()?;
    let sizes = TargetSizes { limits: &limits[n_unchanged..], n_without_dropping: 0 };
    let simplified_levels = simplify_closed(&input, weights, task, &sizes, progress)?;
    let levels = unchanged.into_iter().chain(simplified_levels.into_iter().map(|closed| closed.into_result()));
    let renumber = |derivative| used.renumber_derivative(derivative);
    Ok(levels.map(|(simplified, derivative)| (used.renumber(simplified), derivative.map(renumber))).collect())
}

fn run_paper(
    input: &Input,
    weights: Option<&Weights>,
    options: &PaperOptions,
    target: Target,
    progress: Progress,
) -> Result<Simplified, SimplifyError> {
    input.check()?;
    let used = UsedMesh::new(progress.pulse, input.mesh)?;
    let limit = resolve_limit(&used.mesh, target)?;
    let simplified = if limit.is_met_by(&used.mesh) {
        unchanged_result(progress.pulse, &Input { mesh: &used.mesh, ..*input }, ScoreSource::Network)
    } else {
        simplify_by_paper(&used.mesh, weights, options, limit, progress)?
    };
    Ok(used.renumber(simplified))
}
