//! The closed assembly: prepare, collapse, refine. Closed inputs give closed results.

mod attributes;
mod ceilings;
mod coarsening;
mod collapse;
mod collapse_base;
mod derivative;
mod deviation_check;
mod diamond;
mod dropping;
mod faces_around;
mod importance;
mod kept_way;
mod kernel_collapse;
mod level_queue;
mod occupied_cells;
mod original;
mod output;
mod pins;
mod prepare;
mod progression;
mod refine;
mod request;
mod result;
mod saved_collapse;
mod split_sequence;
mod stage_settings;
mod trace;
mod visible_drops;

use neural_mesh_collapse::CollapseResult;

use crate::mesh::pulse::Pulse;
use crate::mesh::{Attributes, Frame, TriMesh, topology};

use super::limits::Limit;
use super::options::SimplifyError;
use super::progress::Progress;
use ceilings::find_ceilings;
use coarsening::coarsen;
use collapse::{Collapse, Constraints, Poses, merges_to, size_with_shape, sum_attribute_quadrics};
use collapse_base::CollapseBase;
use deviation_check::DeviationCheck;
use kept_way::KeptWay;
use kernel_collapse::{KernelCollapse, KernelTurns, collapse_by_kernel, is_kernel_enough};
use original::Original;
use output::Output;
use prepare::{prepare, prepare_bare};
use refine::sample_points::SamplePoints;
use refine::{degenerate_faces, duplicate_positions, fit, flips, foldovers, nested, spikes};
use trace::Trace;

pub(super) use collapse::{CollapseEnd, RecordedMerge};
pub(super) use derivative::Derivative;
pub(super) use dropping::{DroppedFaces, VertexCost, vertex_components};
pub use importance::importance_of_scores;
pub(super) use level_queue::{ChangedResults, LevelQueue, LimitList, NextLevel};
pub(super) use progression::{LevelChoice, ProgressionSurface, RecordedCollapse, prices_by_size, record_collapse};
pub(super) use request::{ClosedRequest, Task};
pub(super) use result::ClosedResult;
use saved_collapse::SavedCollapse;

/// Least number of input vertices per output vertex at which flips run.
// Below, the collapse finds good diagonals. Nineteen meshes, ratios 0.01 to 0.05: the mean distance is 0.7 % larger at
// 30, 2.6 % without flips.
const COARSE_RATIO: usize = 15;

/// State that the levels of one request share.
#[derive(Default)]
pub(super) struct LevelState<'a> {
    /// Number of sizes, from the next, at which no further component is dropped.
    pub n_without_dropping: usize,
    /// Size at which every component keeps its shape, if a level before went below it.
    pub size_with_shape: Option<(usize, usize)>,
    pub saved: Option<SavedCollapse<'a>>,
}

/// Simplifies to the sizes of a queue with one collapse; only the first level has a derivative.
///
/// Ends before a size at which components should be dropped, and returns them, and before one that is larger than the last.
pub(super) fn simplify_levels<'a>(
    request: &ClosedRequest,
    state: &mut LevelState<'a>,
    queue: &mut dyn LevelQueue,
    progress: Progress<'a>,
) -> Result<Option<DroppedFaces>, SimplifyError> {
    let is_kernel_enough = |next: &NextLevel| is_kernel_enough(request, next.limit);
    if state.saved.is_none() && queue.next().is_some_and(|next| is_kernel_enough(&next)) {
        let dropped = simplify_by_kernel(request, state, queue, progress)?;
        if dropped.is_some() {
            return Ok(dropped);
        }
    }
    // Smaller sizes are for the collapse of this assembly, which makes no estimates.
    while queue.next().is_some_and(|next| next.is_estimate) {
        queue.take_estimates(&[]);
    }
    simplify_by_merges(request, state, queue, progress)
}

/// Simplifies by the collapse of this assembly; ends as [`simplify_levels`].
fn simplify_by_merges<'a>(
    request: &ClosedRequest,
    state: &mut LevelState<'a>,
    queue: &mut dyn LevelQueue,
    progress: Progress<'a>,
) -> Result<Option<DroppedFaces>, SimplifyError> {
    let Some(NextLevel { limit: first, .. }) = queue.next() else { return Ok(None) };
    let (base, collapse) = start_or_continue(request, first, state.saved.take(), progress)?;
    let deviation_check = deviation_check(request, &collapse, queue.least());
    // The copy continues after components are dropped.
    let may_drop = request.task.drops_within().is_some();
    let mut collapse = Some(if may_drop && !request.task.differentiable { collapse.with_copy() } else { collapse });
    let (mut way, mut last) = (KeptWay::new(queue.may_grow()), None);
    while let Some(NextLevel { limit, is_last, .. }) = queue.next() {
        if last.is_some_and(|last| limit.size() > last) {
            collapse = way.go_back(limit);
        }
        // The last level takes the collapse itself, not a copy, to save memory.
        let Some(mut running) = collapse.take() else { break };
        // The first level has entered this stage in `start`.
        if last.is_some() {
            progress.enter("collapse", running.merges_to(limit))?;
        }
        way.go_part(&mut running, limit);
        let ended = end_level(&base, request, running, deviation_check.as_ref(), limit, state);
        let EndedCollapse { collapse: mut running, end, output, dropped } = ended;
        if let Some(dropped) = dropped {
            state.saved = running.take_copy().and_then(|copy| SavedCollapse::from_copy(&dropped, &base, copy, limit));
            return Ok(Some(dropped));
        }
        // Only the first level has a history: later ones find it taken.
        let trace = start_trace(running.history.take());
        let pass_prices = base.pass_prices(running.pass_prices());
        let size_by_prices = running.size_with_shape(base.original.surface.area());
        collapse = keep_for_next(running, is_last);
        let mut result = refine(&base, request, output, end, trace, progress)?.with_prices(pass_prices);
        result.simplified.report.size_with_shape = state.size_with_shape.or(size_by_prices);
        state.n_without_dropping = state.n_without_dropping.saturating_sub(1);
        last = Some(limit.size());
        queue.take(result)?;
    }
    Ok(None)
}

/// Comes down to a size, as near as the shape allows and then nearer, or finds components to go before it.
fn end_level<'a>(
    base: &CollapseBase,
    request: &ClosedRequest,
    running: Collapse<'a>,
    deviation_check: Option<&DeviationCheck<'a>>,
    limit: Limit,
    state: &mut LevelState,
) -> EndedCollapse<'a> {
    let may_drop_now = state.n_without_dropping == 0;
    let ended = run_and_choose(base, running, deviation_check, request, limit, may_drop_now);
    if ended.dropped.is_some() || ended.end == CollapseEnd::Reached || request.task.options.hold_shape.is_some() {
        return ended;
    }
    // Shapes of components and curves give way before the size does.
    state.size_with_shape = state.size_with_shape.or(Some(ended.collapse.size()));
    coarsen_and_choose(base, request, ended, limit)
}

/// Simplifies to one size, dropping nothing.
pub(super) fn simplify_to_limit(
    request: &ClosedRequest,
    limit: Limit,
    progress: Progress,
) -> Result<ClosedResult, SimplifyError> {
    let limits = [limit];
    let mut queue = LimitList::new(&limits);
    simplify_levels(request, &mut LevelState::default(), &mut queue, progress)?;
    queue.results.pop().ok_or(SimplifyError::Empty)
}

/// Simplifies by the kernel; ends before a size out of its reach, or at which components should be dropped.
fn simplify_by_kernel<'a>(
    request: &ClosedRequest,
    state: &mut LevelState<'a>,
    queue: &mut dyn LevelQueue,
    progress: Progress<'a>,
) -> Result<Option<DroppedFaces>, SimplifyError> {
    let Some(first) = queue.next() else { return Ok(None) };
    let mesh = request.task.input.mesh;
    let (n_vertices, n_faces) = (mesh.positions().len(), mesh.faces().len());
    progress.enter("surface", n_faces)?;
    let original = prepare_bare(request, progress.pulse);
    // The kernel weighs vertices as it prices them.
    progress.enter("scores", 0)?;
    let base = CollapseBase { original, collapse_vertices: Vec::new() };
    let enter_collapse = |limit: Limit, n_vertices: usize, n_faces: usize| {
        progress.enter("collapse", merges_to(limit, n_vertices, n_faces))
    };
    enter_collapse(first.limit, n_vertices, n_faces)?;
    let mut ended = Ok(None);
    // Only the first level has a derivative.
    let mut is_recorded = request.task.differentiable;
    let turns = KernelTurns { first, keeps_way: queue.may_grow(), records_merges: is_recorded };
    collapse_by_kernel(&base.original, turns, progress.pulse, |collapsed| {
        let next = queue.next()?;
        let size = [collapsed.positions.len(), collapsed.faces.len()];
        ended = if next.is_estimate {
            queue.take_estimates(&base.pass_distances(&collapsed.pass_errors));
            Ok(None)
        } else {
            finish_level(&base, request, (collapsed, next.limit, is_recorded), state, queue, progress)
        };
        is_recorded = false;
        let next = queue.next().filter(|next| matches!(ended, Ok(None)) && is_kernel_enough(request, next.limit))?;
        ended = enter_collapse(next.limit, size[0], size[1]).map(|()| None);
        ended.is_ok().then_some(next)
    });
    ended
}

/// Refines a level of the kernel and hands it over, or finds components that should go before it.
fn finish_level(
    base: &CollapseBase,
    request: &ClosedRequest,
    (collapsed, limit, is_recorded): (CollapseResult, Limit, bool),
    state: &mut LevelState,
    queue: &mut dyn LevelQueue,
    progress: Progress,
) -> Result<Option<DroppedFaces>, SimplifyError> {
    let original = &base.original;
    let KernelCollapse { output, history, pass_prices } = KernelCollapse::new(collapsed, original);
    if let Some(within) = request.task.drops_within().filter(|_| state.n_without_dropping == 0) {
        let cost = VertexCost { pass_prices: &pass_prices, limit, must_fit: false };
        let dropped = dropping::choose_dropped(original, &output, &cost, within, &request.visual_properties());
        if dropped.is_some() {
            return Ok(dropped);
        }
    }
    let size = [output.positions.len(), output.faces().len()];
    let n_input = original.mesh.positions().len();
    let size_with_shape = size_with_shape(&pass_prices, n_input, size, original.surface.area());
    let trace = start_trace(is_recorded.then_some(history));
    let mut result = refine(base, request, output, CollapseEnd::Reached, trace, progress)?;
    result.simplified.report.size_with_shape = size_with_shape;
    state.n_without_dropping = state.n_without_dropping.saturating_sub(1);
    queue.take(result.with_prices(base.pass_prices(&pass_prices)))?;
    Ok(None)
}

struct EndedCollapse<'a> {
    collapse: Collapse<'a>,
    end: CollapseEnd,
    output: Output,
    /// Components to go before the level is made.
    dropped: Option<DroppedFaces>,
}

/// Runs a collapse to a limit, and chooses components whose vertices are better spent elsewhere.
fn run_and_choose<'a>(
    base: &CollapseBase,
    collapse: Collapse<'a>,
    deviation_check: Option<&DeviationCheck<'a>>,
    request: &ClosedRequest,
    limit: Limit,
    may_drop: bool,
) -> EndedCollapse<'a> {
    let (collapse, end) = run(base, collapse, deviation_check, request, limit);
    let output = base.output(&collapse);
    // Where the size is out of reach, views decide for assets.
    let is_by_price = may_drop && (end == CollapseEnd::Reached || !request.drops_by_views());
    let choose = || choose_dropped(base, request, (&collapse, end), &output, limit);
    let dropped = if is_by_price { choose() } else { None };
    EndedCollapse { collapse, end, output, dropped }
}

/// Continues a collapse that ended above its limit, and chooses components that go instead.
fn coarsen_and_choose<'a>(
    base: &CollapseBase,
    request: &ClosedRequest,
    ended: EndedCollapse<'a>,
    limit: Limit,
) -> EndedCollapse<'a> {
    let mut collapse = ended.collapse.with_copy_if_wanted();
    let may_drop = request.task.drops_within().is_some();
    let coarse = coarsen(base, &mut collapse, ended.end, limit, may_drop);
    let output = base.output(&collapse);
    let dropped = coarse.choose_dropped(base, request, &output, limit);
    EndedCollapse { end: coarse.end, collapse, output, dropped }
}

fn deviation_check<'a>(request: &ClosedRequest, collapse: &Collapse<'a>, least: usize) -> Option<DeviationCheck<'a>> {
    // Ceilings already bound the distance, and a price or an insisted size overrules the check.
    let is_needed = request.price.is_none() && !request.task.forces_size && !collapse.has_ceilings();
    is_needed.then(|| DeviationCheck::new(collapse, least)).flatten()
}

fn choose_dropped(
    base: &CollapseBase,
    request: &ClosedRequest,
    (ended, end): (&Collapse, CollapseEnd),
    output: &Output,
    limit: Limit,
) -> Option<DroppedFaces> {
    let within = request.task.drops_within()?;
    let cost = VertexCost::new(ended, limit, end);
    dropping::choose_dropped(&base.original, output, &cost, within, &request.visual_properties())
}

/// Returns the collapse for the next level; after the last level frees it.
fn keep_for_next(collapse: Collapse, is_last: bool) -> Option<Collapse> {
    if is_last {
        collapse.free_memory();
        return None;
    }
    Some(collapse)
}

fn start_or_continue<'a, 'p: 'a>(
    request: &ClosedRequest<'a>,
    limit: Limit,
    saved: Option<SavedCollapse<'p>>,
    progress: Progress<'p>,
) -> Result<(CollapseBase<'a>, Collapse<'p>), SimplifyError> {
    if let Some(saved) = saved
        && let Some(continued) = saved.attach(request, limit, progress)?
    {
        return Ok(continued);
    }
    start(request, limit, progress)
}

/// Runs a collapse to a limit, or to an earlier end where too few vertices are free to keep the shape.
fn run<'a>(
    base: &CollapseBase,
    mut collapse: Collapse<'a>,
    deviation_check: Option<&DeviationCheck<'a>>,
    request: &ClosedRequest,
    limit: Limit,
) -> (Collapse<'a>, CollapseEnd) {
    let end = collapse.run(base.limit(request.price, limit));
    // Distances are measured on the output over this surface, also where the collapse is a saved one from before
    // components were dropped.
    let distance = |of: &Collapse| deviation_check::distance(&base.original, &base.output(of));
    let repeated = deviation_check.and_then(|it| it.repeat_if_too_far(&collapse, limit, distance));
    repeated.unwrap_or((collapse, end))
}

fn start_trace(history: Option<Vec<collapse::CollapseEvent>>) -> Option<Trace> {
    Some(Trace { history: history?, ..Trace::default() })
}

fn start<'a, 'p: 'a>(
    request: &ClosedRequest<'a>,
    limit: Limit,
    progress: Progress<'p>,
) -> Result<(CollapseBase<'a>, Collapse<'p>), SimplifyError> {
    let (n_faces, task) = (request.task.input.mesh.faces().len(), &request.task);
    progress.enter("surface", n_faces)?;
    let mut original = prepare(request, progress.pulse);
    progress.enter("scores", n_faces)?;
    // Importance must precede the collapse, which copies the quadrics.
    importance::weigh(&mut original.surface, request.importance, request.settings.strength, &request.visibility);
    progress.enter("collapse", merges_to(limit, original.surface.n_vertices(), n_faces))?;
    // Without constraints the collapse takes its fast paths.
    let constrains = !original.features.is_empty() || !original.pins.is_empty();
    let constraints = constrains.then(|| Constraints::new(&original));
    // Everything that adds to prices is set before the first pass.
    let attributes = sum_attribute_quadrics(&original);
    let poses = Poses::new(&original, task);
    let collapse = Collapse::new(progress.pulse, &original.surface);
    let collapse = collapse.with_ceilings(find_ceilings(&original, task));
    let collapse = collapse.with_constraints(constraints, attributes, poses, task.differentiable.then(Vec::new));
    // Only the collapse reads the quadrics.
    original.surface.quadrics = Vec::new();
    Ok((CollapseBase { original, collapse_vertices: Vec::new() }, collapse))
}

fn refine(
    base: &CollapseBase,
    request: &ClosedRequest,
    mut output: Output,
    end: CollapseEnd,
    mut trace: Option<Trace>,
    progress: Progress,
) -> Result<ClosedResult, SimplifyError> {
    let original = &base.original;
    let map = request.task.options.map;
    let attributes = original.attributes.as_deref().or(map.then_some(Attributes::NONE));
    // Flips and fit share the points: each assignment starts from the faces of the last one.
    let mut points = SamplePoints::new(&original.surface, output.positions.len(), request.settings);
    progress.enter("flips", points.len())?;
    // The collapse leaves good diagonals unless the result is coarse.
    let is_coarse = COARSE_RATIO * output.positions.len() <= original.surface.n_vertices();
    // Wedges follow from the collapse's faces, so they are recorded before any flip.
    attributes.into_iter().for_each(|attributes| output.record_attributes(original, attributes));
    let is_whole = output.positions.len() == original.surface.n_vertices();
    let n_turned = if is_coarse && request.runs_flips() { flips::flip(&mut points, &mut output) } else { 0 };
    progress.enter("fit", points.len())?;
    trace.iter_mut().for_each(|trace| trace.faces = output.faces().to_vec());
    // A mesh that lost no vertex is not moved: its vertices already lie on the original.
    if !is_whole && request.runs_fit() {
        fit::fit(original, &mut points, &mut output, &mut trace);
        let task = request.task;
        nested::separate_nested(original, &mut output, task.pieces_placed_alike(), task.is_asset());
    }
    progress.enter("finish", output.faces().len())?;
    // Foldovers and spikes come after all other moves of vertices, duplicates last: they depend on the rounded positions.
    let [n_folded, n_spikes] = repair_surface(original, &mut output, request, is_coarse);
    let (positions, [n_flat, n_separated]) = round_positions(original, &mut output, request, progress.pulse);
    // Attributes come last: they are looked up and fitted at the final positions.
    let corner_values = attributes.and_then(|attributes| output.take_attributes(original, attributes));
    let (attributes, corner_map) = corner_values.unzip();
    let derivative = trace.map(|trace| Derivative::new(original, trace, &output.vertex_of, &positions));
    let mut closed = ClosedResult::new(original, output, positions, request.task.input.kept)?;
    closed.derivative = derivative;
    let map = corner_map.filter(|_| map).map(|corners| closed.build_map(original.mesh, corners));
    let simplified = &mut closed.simplified;
    (simplified.attributes, simplified.map) = (attributes.unwrap_or_default(), map);
    let report = &mut simplified.report;
    report.flipped_edges = n_turned + n_folded + n_flat;
    (report.separated_vertices, report.shortened_spikes) = (n_separated, n_spikes);
    base.complete_report(report, request, end);
    Ok(closed)
}

/// Repairs foldovers and shortens spikes; returns the numbers of flipped edges and moved vertices.
fn repair_surface(original: &Original, output: &mut Output, request: &ClosedRequest, is_coarse: bool) -> [usize; 2] {
    if output.positions.len() == original.surface.n_vertices() {
        return [0; 2];
    }
    let n_flipped = foldovers::repair(original, output, is_coarse);
    // A repair can make spikes, but shortening a spike turns no face.
    let n_spikes =
        if request.task.options.subset { 0 } else { spikes::shorten(original, output, request.settings.least_spike) };
    [n_flipped, n_spikes]
}

/// Rounds positions to local coordinates and repairs the effects of rounding.
///
/// Returns the positions, and the numbers of flipped edges and moved vertices.
fn round_positions(
    original: &Original,
    output: &mut Output,
    request: &ClosedRequest,
    pulse: Pulse,
) -> (Vec<[f32; 3]>, [usize; 2]) {
    let is_whole = output.positions.len() == original.surface.n_vertices();
    let mut positions = result::local_positions(original, output);
    let (n_flipped, are_wide) = if is_whole {
        (0, true)
    } else {
        degenerate_faces::flip(pulse, output, &positions, &request.task.options.frame)
    };
    // Moving a vertex off a duplicate may flatten a face, so widening follows.
    let n_separated = duplicate_positions::separate(pulse, &mut positions, &output.pins, &request.task.options.frame);
    if !are_wide || n_separated > 0 {
        degenerate_faces::widen(original, output, &mut positions, &request.task.options.frame);
    }
    (positions, [n_flipped, n_separated])
}

pub(super) fn is_sound(mesh: &TriMesh, frame: &Frame) -> bool {
    let topology = topology(mesh);
    topology.non_manifold_edges + topology.non_manifold_vertices + topology.inconsistent_edges == 0
        && duplicate_positions::are_apart(Pulse::NONE, mesh.positions(), frame)
}
