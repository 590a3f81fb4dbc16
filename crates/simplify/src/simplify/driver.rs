//! Driver of both assemblies: from the caller's mesh and options to results.

use super::assemblies::{simplify_by_paper, simplify_closed, unchanged_result};
use super::cards::Cards;
use super::closed::{
    ChangedResults, ClosedResult, Derivative, LevelQueue, LevelState, LimitList, NextLevel, Task, is_sound,
};
use super::components::prune;
use super::input::Input;
use super::limits::{Limit, resolve_levels, resolve_limit};
use super::map::identity_map;
use super::network_scores::used_scores;
use super::options::{Assembly, Listener, Options, PaperOptions, ScoreSource, Simplified, SimplifyError};
use super::progress::{LOOK, PAPER_STAGES, Progress, closed_stages, run_with_listener};
use super::size::Size;
use super::sub_mesh::SubMesh;
use super::turns::{ChooseSize, NextSize, Turn};

/// Sizes that a search looks at, and the share of the mesh at the first.
const USUAL_TURNS: usize = 6;
const USUAL_SHARE: f64 = 0.02;

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
    run_with_listener(listener, &closed_stages(sizes.len(), share), |progress| {
        let mut levels = Vec::new();
        run_closed(task, progress, |task, lift| {
            let limits = resolve_levels(task.input.mesh, sizes)?;
            let mut list = LimitList::new(&limits);
            run_queue(task, &mut list, progress)?;
            list.results.iter_mut().for_each(lift);
            levels = list.results.into_iter().map(|closed| (closed.simplified, closed.derivative)).collect();
            Ok(())
        })?;
        Ok(levels)
    })
}

/// Simplifies to sizes that are chosen by the results before; see [`simplify_in_turn`](super::simplify_in_turn).
pub(super) fn run_in_turn(
    task: &Task,
    first: NextSize,
    listener: &mut Listener,
    choose: &mut ChooseSize,
) -> Result<(), SimplifyError> {
    run_with_listener(listener, &closed_stages(USUAL_TURNS, USUAL_SHARE), |progress| {
        run_closed(task, progress, |task, lift| {
            let n_faces = task.input.mesh.faces().len();
            let mut queue = ChosenSizes { next: Some(first), lift, choose, progress, n_faces };
            run_queue(task, &mut queue, progress)
        })
    })
}

/// Sizes of a caller that looks at each result before it chooses the next.
struct ChosenSizes<'a, 'c> {
    next: Option<NextSize>,
    lift: &'a dyn Fn(&mut ClosedResult),
    choose: &'a mut ChooseSize<'c>,
    progress: Progress<'a>,
    n_faces: usize,
}

impl LevelQueue for ChosenSizes<'_, '_> {
    fn next(&self) -> Option<NextLevel> {
        let NextSize { n_vertices, is_estimate } = self.next?;
        Some(NextLevel { limit: Limit::from_vertices(n_vertices.max(1)), is_last: false, is_estimate })
    }

    fn take(&mut self, mut result: ClosedResult) -> Result<(), SimplifyError> {
        (self.lift)(&mut result);
        self.progress.enter(LOOK, self.n_faces)?;
        self.next = (self.choose)(Turn::Result(Box::new(result.simplified)));
        Ok(())
    }

    fn take_estimates(&mut self, estimates: &[(usize, f64)]) {
        self.next = (self.choose)(Turn::Estimates(estimates));
    }

    fn may_grow(&self) -> bool {
        true
    }

    fn least(&self) -> usize {
        1
    }
}

/// Prepares what all levels share, and calls `work` with a task whose vertices are all used and with what completes results.
fn run_closed(
    task: &Task,
    progress: Progress,
    work: impl FnOnce(&Task, &dyn Fn(&mut ClosedResult)) -> Result<(), SimplifyError>,
) -> Result<(), SimplifyError> {
    task.input.check()?;
    let scores = used_scores(&task.input, task.options);
    let task = &task.with_scores(&scores);
    progress.enter("surface", task.input.mesh.faces().len())?;
    // Unused vertices are removed first and restored in the results.
    let used = SubMesh::without_unused_vertices(progress.pulse, &task.input)?;
    let lift = |closed: &mut ClosedResult| used.lift(&mut closed.simplified, &mut closed.derivative);
    work(&Task { input: used.input(), ..*task }, &lift)
}

/// Makes the sizes of a queue; those at or above the size of the input return it, if it is sound.
fn run_queue(task: &Task, queue: &mut dyn LevelQueue, progress: Progress) -> Result<(), SimplifyError> {
    let Task { ref input, options, .. } = *task;
    let is_met =
        |queue: &dyn LevelQueue| queue.next().is_some_and(|next| !next.is_estimate && next.limit.is_met_by(input.mesh));
    let returns_input = is_met(queue) && is_sound(input.mesh, &options.frame);
    // Components that the options drop in any case are removed before anything is prepared.
    let pruned = prune(progress.pulse, input, options)?;
    let lift = |closed: &mut ClosedResult| pruned.lift(&mut closed.simplified, &mut closed.derivative);
    let mut queue = ChangedResults::new(queue, lift).keeping_whole(input.mesh);
    let task = &Task { input: pruned.input(), ..*task };
    while returns_input && is_met(&queue) {
        let mesh = task.input.mesh;
        let map = options.map.then(|| identity_map(mesh));
        let unchanged = unchanged_result(progress.pulse, &task.input, options.scores);
        queue.take(ClosedResult::unchanged(Simplified { map, ..unchanged }))?;
    }
    while queue.next().is_some() {
        simplify_with_cards(task, &mut queue, progress)?;
    }
    Ok(())
}

/// Makes the sizes of a queue; the cards of a mesh become fewer first, for each size by itself.
fn simplify_with_cards(task: &Task, queue: &mut dyn LevelQueue, progress: Progress) -> Result<(), SimplifyError> {
    let Task { ref input, options, .. } = *task;
    // Cards move, and go, only where a size is all that is asked for.
    let may_thin = options.prune && options.prune_within.is_infinite() && options.hold_shape.is_none();
    let is_free = may_thin && !(options.lock_boundaries || options.subset || options.map || task.differentiable);
    let cards = if is_free { Cards::find(input) } else { Cards::default() };
    if cards.is_empty() {
        return simplify_closed(task, &mut LevelState::default(), queue, progress);
    }
    while let Some(NextLevel { limit, is_estimate, .. }) = queue.next() {
        if is_estimate {
            queue.take_estimates(&[]);
            continue;
        }
        let thinned = cards.thin(input, limit)?;
        let thin_task = Task { input: thinned.input(), ..*task };
        let limits = [limit];
        let mut list = LimitList::new(&limits);
        simplify_closed(&thin_task, &mut LevelState::default(), &mut list, progress)?;
        for mut closed in list.results {
            thinned.lift(&mut closed.simplified, &mut closed.derivative);
            queue.take(closed)?;
        }
    }
    Ok(())
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
