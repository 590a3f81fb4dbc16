//! The two assemblies as the driver runs them: what the options ask for on the way in, what is told on the way out.

use crate::mesh::pulse::Pulse;
use crate::mesh::{Attributes, TriMesh, compact};
use crate::model::Weights;

use super::closed::{Aim, Closed, Half, Importance, Keep, Request, simplify_levels};
use super::components::{Prune, Pruned, pruned};
use super::input::{Input, kept_edges, locked_vertices};
use super::limits::Limit;
use super::map;
use super::options::{Assembly, Options, Parts, Report, ScoreSource, Simplified, SimplifyError};
use super::paper;
use super::progress::Progress;

/// What is asked of a run.
pub(super) struct Task<'a> {
    /// What the caller asked for.
    pub options: &'a Options,
    /// Whether the closed result is to be known as a function of the positions.
    pub differentiable: bool,
    /// Where the mesh is one half of a mirrored one.
    pub half: Option<Half<'a>>,
}

/// Sizes to reach, each no larger than the one before, and samples per vertex asked for.
pub(super) struct Sizes<'a> {
    /// The sizes.
    pub limits: &'a [Limit],
    /// Samples per vertex of the first.
    pub oversample: f64,
}

/// The closed assembly's results of a mesh: of the first size, and from where its collapse stood then, of the further ones.
pub(super) fn closed_levels(
    input: &Input,
    weights: Option<&Weights>,
    task: &Task,
    sizes: &Sizes,
    progress: Progress,
) -> Result<Vec<Closed>, SimplifyError> {
    let Some(&first) = sizes.limits.first() else { return Ok(Vec::new()) };
    let Some(pruned) = pruned_for(progress.pulse, input.mesh, first, task.options) else {
        return levels_of(input, weights, task, sizes, progress);
    };
    let (attributes, importance) = input.part(&pruned.sources, &pruned.faces)?;
    let part = Input { mesh: &pruned.mesh, attributes: &attributes, importance: &importance };
    let mut levels = levels_of(&part, weights, task, sizes, progress)?;
    levels.iter_mut().for_each(|closed| closed.widen(input.mesh, &pruned));
    Ok(levels)
}

/// The mesh without the components that the options let go; `None` where all stay.
fn pruned_for(pulse: Pulse, mesh: &TriMesh, limit: Limit, options: &Options) -> Option<Pruned> {
    let prune = Prune { for_target: options.prune.then_some(limit.size()), below: options.prune_below };
    if options.prune || prune.below > 0.0 { pruned(pulse, mesh, &prune) } else { None }
}

/// The closed assembly's results of all of a mesh.
fn levels_of(
    input: &Input,
    weights: Option<&Weights>,
    task: &Task,
    sizes: &Sizes,
    progress: Progress,
) -> Result<Vec<Closed>, SimplifyError> {
    let Task { options, differentiable, half } = *task;
    let Input { mesh, attributes, importance } = *input;
    let aim = Aim::of(options.optimize);
    let scores = if aim.strength > 0.0 { options.scores } else { ScoreSource::Geometry };
    let importance = match scores {
        _ if !importance.is_empty() => Importance::Given(importance),
        ScoreSource::Network => Importance::Network(weights.unwrap_or_else(|| Weights::shipped_default())),
        ScoreSource::Geometry => Importance::Even,
    };
    let edges = kept_edges(mesh, attributes, options);
    let locked = locked_vertices(mesh, options);
    let attributes = Some(attributes).filter(|attributes| !attributes.is_empty());
    let keep = Keep { edges: &edges, locked: &locked, subset: options.subset, attributes, map: options.map, half };
    let request = Request {
        oversample: sizes.oversample,
        all_if_uneven: options.oversample.is_none(),
        importance,
        aim,
        parts: Parts::default(),
        seed: options.seed,
        frame: options.frame,
        differentiable,
        keep,
    };
    let mut levels = simplify_levels(mesh, &request, sizes.limits, progress)?;
    levels.iter_mut().for_each(|closed| closed.report.scores = scores);
    Ok(levels)
}

/// The paper's assembly's result of a mesh, over the vertices of the mesh.
pub(super) fn paper_result(
    mesh: &TriMesh,
    weights: Option<&Weights>,
    options: &Options,
    limit: Limit,
    progress: Progress,
) -> Result<Simplified, SimplifyError> {
    let weights = weights.unwrap_or_else(|| Weights::shipped_paper_open());
    let n_target = limit.vertices.min((limit.faces / 2).max(3));
    let result = paper::simplified(mesh, n_target, weights, options.seed, progress)?;
    let (mesh, kept) = compact(mesh.positions(), result.faces).map_err(|_| SimplifyError::Overflow)?;
    let report = Report::of(progress.pulse, &mesh);
    let attributes = Attributes::default();
    Ok(Simplified { mesh, attributes, source_vertices: Some(kept), map: None, report })
}

/// The mesh as it is, for targets that it meets already.
pub(super) fn unchanged(pulse: Pulse, input: &Input, options: &Options, oversample: f64) -> Simplified {
    let mesh = input.mesh;
    let scores = if options.assembly == Assembly::Closed { options.scores } else { ScoreSource::Network };
    Simplified {
        mesh: mesh.clone(),
        attributes: input.attributes.clone(),
        source_vertices: Some((0..mesh.positions().len() as u32).collect()),
        map: options.map.then(|| map::of_unchanged(mesh)),
        report: Report { oversample, scores, ..Report::of(pulse, mesh) },
    }
}

/// The same without the components below the size that the options let go.
pub(super) fn unchanged_but_pruned(
    pulse: Pulse,
    input: &Input,
    options: &Options,
    oversample: f64,
) -> Result<Simplified, SimplifyError> {
    let prune = Prune { for_target: None, below: options.prune_below };
    let dropped = if prune.below > 0.0 { pruned(pulse, input.mesh, &prune) } else { None };
    let Some(pruned) = dropped else { return Ok(unchanged(pulse, input, options, oversample)) };
    let (attributes, importance) = input.part(&pruned.sources, &pruned.faces)?;
    let part = Input { mesh: &pruned.mesh, attributes: &attributes, importance: &importance };
    let mut result = unchanged(pulse, &part, options, oversample);
    result.report.components_pruned = pruned.n_dropped;
    result.map.iter_mut().for_each(|map| map::widen_pruned(map, input.mesh, &pruned));
    result.source_vertices = Some(pruned.sources);
    Ok(result)
}
