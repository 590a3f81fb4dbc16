//! Functions that run either assembly, from options to results.

use crate::mesh::pulse::Pulse;
use crate::mesh::{Attributes, Role, TriMesh, compact, is_shaded_flat, with_flat_normals};
use crate::model::{Weights, paper_weights};

use super::closed::{
    ClosedRequest, ClosedResult, DropRules, FinishedLevels, Half, Importance, Requirements, SavedCollapse,
    StageSettings, simplify_levels,
};
use super::components::{PrunedMesh, prune, remove_faces};
use super::hidden::hidden_vertices;
use super::input::{Input, kept_edges, locked_vertices};
use super::limits::Limit;
use super::map;
use super::options::{
    ClosedOptions, Hidden, PaperOptions, Purpose, Refinements, Report, ScoreSource, Simplified, SimplifyError,
};
use super::paper;
use super::progress::Progress;

pub(super) struct Task<'a> {
    pub options: &'a ClosedOptions,
    pub differentiable: bool,
    /// True to reach the size even where too few vertices are free to keep the shape.
    pub forces_size: bool,
    pub half: Option<Half<'a>>,
}

impl<'a> Task<'a> {
    pub fn new(options: &'a ClosedOptions) -> Self {
        Self { options, differentiable: false, forces_size: false, half: None }
    }
}

pub(super) struct TargetSizes<'a> {
    pub limits: &'a [Limit],
    /// Number of sizes, from the first, at which no further component is dropped.
    pub n_without_dropping: usize,
}

/// Simplifies a mesh to several sizes, each continuing the collapse of the one before.
pub(super) fn simplify_closed(
    input: &Input,
    weights: Option<&Weights>,
    task: &Task,
    sizes: &TargetSizes,
    progress: Progress,
) -> Result<Vec<ClosedResult>, SimplifyError> {
    // Components that the options drop in any case are removed before anything is prepared.
    let Some(pruned) = prune(progress.pulse, input, task.options) else {
        return simplify_dropping(input, weights, task, sizes, None, progress);
    };
    simplify_pruned(input, &pruned, |rest| simplify_dropping(rest, weights, task, sizes, None, progress))
}

fn simplify_pruned(
    input: &Input,
    pruned: &PrunedMesh,
    make: impl FnOnce(&Input) -> Result<Vec<ClosedResult>, SimplifyError>,
) -> Result<Vec<ClosedResult>, SimplifyError> {
    let rest = input.select(&pruned.sources, &pruned.faces)?;
    let mut levels = make(&rest.to_input(&pruned.mesh, input.scene))?;
    levels.iter_mut().for_each(|closed| closed.renumber(input.mesh, pruned));
    Ok(levels)
}

/// Simplifies to several sizes, dropping components that a viewer would hardly miss.
fn simplify_dropping(
    input: &Input,
    weights: Option<&Weights>,
    task: &Task,
    sizes: &TargetSizes,
    saved: Option<SavedCollapse>,
    progress: Progress,
) -> Result<Vec<ClosedResult>, SimplifyError> {
    let FinishedLevels { mut results, dropped, saved } = simplify_whole(input, weights, task, sizes, saved, progress)?;
    let Some(dropped) = dropped else { return Ok(results) };
    let Some(pruned) = remove_faces(input.mesh, dropped.n_components, |face| dropped.faces[face]) else {
        return Ok(results);
    };
    // At a size where a component is dropped, the rest is simplified again, from a saved collapse if there is one. It
    // then loses no further component.
    let remaining = TargetSizes { limits: &sizes.limits[results.len()..], n_without_dropping: 1 };
    results.extend(simplify_pruned(input, &pruned, |rest| {
        simplify_dropping(rest, weights, task, &remaining, saved, progress)
    })?);
    Ok(results)
}

/// Returns the rules for dropping components from level `from_level` on; `None` if all must stay.
fn drop_rules(input: &Input, options: &ClosedOptions, half: Option<Half>, from_level: usize) -> Option<DropRules> {
    // Constraints of the caller name vertices or faces that must remain.
    let is_constrained = options.subset || options.lock_boundaries || !input.locked.is_empty();
    let keeps_all = !options.prune || is_constrained || half.is_some();
    (!keeps_all).then_some(DropRules { within: options.prune_within, from_level })
}

/// Chooses the source of vertex scores: none if without effect, the network if the caller gives weights.
pub(super) fn score_source(
    options: &ClosedOptions,
    settings: &StageSettings,
    weights: Option<&Weights>,
) -> ScoreSource {
    match options.scores {
        // The purposes Poses and Spectrum distribute the vertices by terms of their own, so scores need given weights
        // there.
        _ if settings.strength == 0.0 || options.purpose != Purpose::Shape && weights.is_none() => {
            ScoreSource::Geometry
        }
        ScoreSource::Bending if weights.is_some() => ScoreSource::Network,
        scores => scores,
    }
}

pub(super) fn choose_importance<'a>(
    given: &'a [f32],
    scores: ScoreSource,
    weights: Option<&'a Weights>,
) -> Importance<'a> {
    match scores {
        // The caller's importance overrules any score.
        _ if !given.is_empty() => Importance::Given(given),
        ScoreSource::Network => Importance::Network(weights.unwrap_or_else(|| Weights::shipped_default())),
        ScoreSource::Bending => Importance::Bending,
        ScoreSource::Geometry => Importance::Even,
    }
}

/// Simplifies without dropping components; stops before the level at which one should be dropped.
fn simplify_whole<'a>(
    input: &Input,
    weights: Option<&Weights>,
    task: &Task,
    sizes: &TargetSizes,
    saved: Option<SavedCollapse<'a>>,
    progress: Progress<'a>,
) -> Result<FinishedLevels<'a>, SimplifyError> {
    let Input { mesh, attributes, .. } = *input;
    // Stored normals that equal the face normals carry no information; they would make every edge a held hard edge.
    let normals = attributes.channels.iter().find(|channel| channel.role == Role::Normal);
    let mut levels = match normals.filter(|_| is_shaded_flat(mesh, attributes)) {
        None => simplify_with_given_normals(input, weights, task, sizes, saved, progress)?,
        Some(normals) => {
            let others = attributes.clone().keep_roles(|role| role != Role::Normal, true);
            let input = Input { attributes: &others, ..*input };
            let mut levels = simplify_with_given_normals(&input, weights, task, sizes, saved, progress)?;
            for closed in &mut levels.results {
                closed.attributes = with_flat_normals(&closed.mesh, &closed.attributes, &normals.name);
            }
            levels
        }
    };
    // Kept faces get all their values back, normals included.
    levels.results.iter_mut().for_each(|closed| closed.restore_kept(attributes));
    Ok(levels)
}

fn simplify_with_given_normals<'a>(
    input: &Input,
    weights: Option<&Weights>,
    task: &Task,
    sizes: &TargetSizes,
    saved: Option<SavedCollapse<'a>>,
    progress: Progress<'a>,
) -> Result<FinishedLevels<'a>, SimplifyError> {
    let Task { options, differentiable, forces_size, half, .. } = *task;
    let Input { mesh, attributes, importance, scene, .. } = *input;
    let settings = StageSettings::new(options.optimize, options.effort);
    // Options, constraints and weights become one request to the closed assembly.
    let scores = score_source(options, &settings, weights);
    let requirements = Requirements {
        edges: &kept_edges(mesh, attributes, options),
        locked: &locked_vertices(input, options),
        attributes: Some(attributes).filter(|attributes| !attributes.is_empty()),
        scene,
        drop: drop_rules(input, options, half, sizes.n_without_dropping),
        half,
        ..Requirements::from_options(options, input.kept)
    };
    let request = ClosedRequest {
        importance: choose_importance(importance, scores, weights),
        hidden: &if options.hidden == Hidden::Cheap { hidden_vertices(input) } else { Vec::new() },
        settings,
        refinements: Refinements::default(),
        frame: options.frame,
        differentiable,
        requirements,
        forces_size,
        price: None,
    };
    let mut levels = simplify_levels(mesh, &request, sizes.limits, saved, progress)?;
    levels.results.iter_mut().for_each(|closed| closed.report.scores = scores);
    Ok(levels)
}

pub(super) fn simplify_by_paper(
    mesh: &TriMesh,
    weights: Option<&Weights>,
    options: &PaperOptions,
    limit: Limit,
    progress: Progress,
) -> Result<Simplified, SimplifyError> {
    let weights = weights.map_or_else(|| paper_weights().ok_or(SimplifyError::NoWeights), Ok)?;
    // The network's target is a number of vertices; a closed surface has about half as many vertices as faces.
    let n_target = limit.vertices.min((limit.faces / 2).max(3));
    let result = paper::simplify_in_run(mesh, n_target, weights, options, progress)?;
    let mut positions = mesh.positions().to_vec();
    result.vertices.iter().zip(&result.positions).for_each(|(&v, &position)| positions[v as usize] = position);
    let (mesh, kept) = compact(&positions, result.faces).map_err(|_| SimplifyError::Overflow)?;
    let report = Report::for_mesh(progress.pulse, &mesh);
    let attributes = Attributes::default();
    Ok(Simplified { mesh, attributes, source_vertices: Some(kept), map: None, report })
}

pub(super) fn unchanged_result(pulse: Pulse, input: &Input, scores: ScoreSource) -> Simplified {
    let mesh = input.mesh;
    Simplified {
        mesh: mesh.clone(),
        attributes: input.attributes.clone(),
        source_vertices: Some((0..mesh.positions().len() as u32).collect()),
        map: None,
        report: Report { scores, ..Report::for_mesh(pulse, mesh) },
    }
}

pub(super) fn pruned_result(pulse: Pulse, input: &Input, options: &ClosedOptions) -> Result<Simplified, SimplifyError> {
    let unchanged = |input: &Input| Simplified {
        map: options.map.then(|| map::identity_map(input.mesh)),
        ..unchanged_result(pulse, input, options.scores)
    };
    let Some(pruned) = prune(pulse, input, options) else { return Ok(unchanged(input)) };
    let rest = input.select(&pruned.sources, &pruned.faces)?;
    let mut result = unchanged(&rest.to_input(&pruned.mesh, input.scene));
    // Report and map name the vertices and faces of the caller's mesh.
    pruned.add_to_report(&mut result.report);
    result.map.iter_mut().for_each(|map| map::renumber_pruned_map(map, input.mesh, &pruned));
    result.source_vertices = Some(pruned.sources);
    Ok(result)
}
