//! Driver of both assemblies: from the caller's mesh and options to results.

use super::assemblies::{simplify_by_paper, simplify_closed, unchanged_result};
use super::cards::Cards;
use super::closed::{ClosedResult, Derivative, Levels, Task, is_sound};
use super::components::prune;
use super::input::Input;
use super::limits::{Limit, resolve_levels, resolve_limit};
use super::map::identity_map;
use super::network_scores::used_scores;
use super::options::{Assembly, Listener, Options, PaperOptions, ScoreSource, Simplified, SimplifyError};
use super::progress::{PAPER_STAGES, Progress, closed_stages, run_with_listener};
use super::size::Size;
use super::sub_mesh::SubMesh;

type TracedResult = (Simplified, Option<Derivative>);

pub(super) fn run(
    input: &Input,
    options: &Options,
    differentiable: bool,
    listener: &mut Listener,
) -> Result<TracedResult, SimplifyError> {
    match &options.assembly {
        Assembly::Closed(closed) => {
            let task = Task { differentiable, ..Task::new(*input, closed) };
            let levels = run_levels(&task, &[options.target], listener)?;
            levels.into_iter().next().ok_or(SimplifyError::Empty)
        }
        Assembly::Paper(paper) => run_with_listener(listener, &PAPER_STAGES, |progress| {
            Ok((run_paper(input, paper, options.target, progress)?, None))
        }),
    }
}

pub(super) fn run_levels(
    task: &Task,
    sizes: &[Size],
    listener: &mut Listener,
) -> Result<Vec<TracedResult>, SimplifyError> {
    // Stages take shares of time that depend on the size of the first level.
    let [n_vertices, n_faces] = [task.input.mesh.positions().len(), task.input.mesh.faces().len()];
    let share = sizes.first().map_or(1.0, |size| size.share_of(n_vertices, n_faces));
    let stages = closed_stages(sizes.len(), share);
    run_with_listener(listener, &stages, |progress| run_closed(task, sizes, progress))
}

fn run_closed(task: &Task, sizes: &[Size], progress: Progress) -> Result<Vec<TracedResult>, SimplifyError> {
    let options = task.options;
    task.input.check()?;
    let scores = used_scores(&task.input, options);
    let task = &task.with_scores(&scores);
    let input = &task.input;
    progress.enter("surface", input.mesh.faces().len())?;
    // Unused vertices are removed first and restored in the results.
    let used = SubMesh::without_unused_vertices(progress.pulse, input)?;
    let input = used.input();
    let mut limits = resolve_levels(input.mesh, sizes)?;
    // A target at or above the input size returns the input.
    let n_met = limits.iter().take_while(|limit| limit.is_met_by(input.mesh)).count();
    let n_unchanged = if n_met > 0 && is_sound(input.mesh, &options.frame) { n_met } else { 0 };
    // Repairs of an unsound mesh split vertices; none is then merged away to make up for them.
    limits[n_unchanged..n_met.max(n_unchanged)].fill(Limit::NONE);
    // Components that the options drop in any case are removed before anything is prepared.
    let pruned = prune(progress.pulse, &input, options)?;
    let input = pruned.input();
    let unchanged = || {
        let map = options.map.then(|| identity_map(input.mesh));
        (Simplified { map, ..unchanged_result(progress.pulse, &input, options.scores) }, None)
    };
    let unchanged: Vec<TracedResult> = (0..n_unchanged).map(|_| unchanged()).collect();
    let simplified_levels = simplify_with_cards(&Task { input, ..*task }, &limits[n_unchanged..], progress)?;
    let mut levels: Vec<TracedResult> = unchanged.into_iter().chain(simplified_levels).collect();
    for (simplified, derivative) in &mut levels {
        pruned.lift(simplified, derivative);
        used.lift(simplified, derivative);
    }
    Ok(levels)
}

/// Simplifies to several sizes; the cards of a mesh become fewer first, for each size by itself.
fn simplify_with_cards(task: &Task, limits: &[Limit], progress: Progress) -> Result<Vec<TracedResult>, SimplifyError> {
    let untie = |closed: ClosedResult| (closed.simplified, closed.derivative);
    let Task { ref input, options, .. } = *task;
    // Cards move, and go, only where a size is all that is asked for.
    let may_thin = options.prune && options.prune_within.is_infinite() && options.hold_shape.is_none();
    let is_free = may_thin && !(options.lock_boundaries || options.subset || options.map || task.differentiable);
    let cards = if is_free { Cards::find(input) } else { Cards::default() };
    if cards.is_empty() {
        let results = simplify_closed(task, Levels::new(limits), progress)?;
        return Ok(results.into_iter().map(untie).collect());
    }
    let mut levels = Vec::with_capacity(limits.len());
    for &limit in limits {
        let thinned = cards.thin(input, limit)?;
        let thin_task = Task { input: thinned.input(), ..*task };
        let results = simplify_closed(&thin_task, Levels::new(&[limit]), progress)?;
        for (mut simplified, mut derivative) in results.into_iter().map(untie) {
            thinned.lift(&mut simplified, &mut derivative);
            levels.push((simplified, derivative));
        }
    }
    Ok(levels)
}

fn run_paper(
    input: &Input,
    options: &PaperOptions,
    target: Size,
    progress: Progress,
) -> Result<Simplified, SimplifyError> {
    input.check()?;
    let used = SubMesh::without_unused_vertices(progress.pulse, input)?;
    let input = used.input();
    let limit = resolve_limit(input.mesh, target)?;
    let mut simplified = if limit.is_met_by(input.mesh) {
        unchanged_result(progress.pulse, &input, ScoreSource::Network)
    } else {
        simplify_by_paper(input.mesh, options, limit, progress)?
    };
    used.lift(&mut simplified, &mut None);
    Ok(simplified)
}
