//! The pipeline, Secs. 3 and 4: a mesh and a target in, a lighter mesh and its story out.

mod bending;
mod closed;
mod components;
mod input;
mod levels;
mod map;
mod mesh_points;
mod network_scores;
mod options;
pub mod paper;
mod record;
mod sample_vertices;
mod scattered_samples;
mod symmetric;
mod versions;
mod weighed;

use std::borrow::Cow;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use rayon::prelude::*;

use crate::mesh::{Attributes, TriMesh, compact};
use crate::model::Weights;
use closed::{Closed, Derivative, End, Half, Keep, Limit, Request, is_sound, simplify_levels};
use components::{Prune, count_components, pruned};

pub use crate::mesh::vertex_normals;
pub use bending::bending_scores;
pub use closed::{Importance, importance_of_scores};
pub use input::{Input, importance_of_channel, importance_of_groups};
pub use levels::simplify_levels_of_detail;
pub use mesh_points::{MeshedPoints, cloud_graph, mesh_points, region_graph};
pub use network_scores::{edge_graph, network_scores, vertex_areas};
pub use options::{
    Assembly, Axis, Event, Map, MirrorPlane, Options, Outcome, Parts, Report, ScoreSource, Simplified, SimplifyError,
    Symmetry, Target,
};
pub use record::Record;
pub use sample_vertices::gumbel_top_k;
pub use scattered_samples::scattered_samples;
pub use versions::{CLOSED_VERSION, PAPER_VERSION};
pub use weighed::{Weighed, simplify_weighed};

/// Samples per vertex asked for at a ratio of 1, where the caller leaves the choice: the fewer are left, the more are
/// looked at for each. Fewer cost accuracy on parts with sharp edges, where every vertex that the samples leave out may
/// have been a corner.
const OVERSAMPLE: f64 = 1.45;

/// Vertices up to which all of them are samples, where the caller leaves the choice: one pass saves time where there is much
/// to save. Twelve meshes of the training set lay a tenth nearer to the original so, their normals a seventh, machine parts most.
const SMALL: usize = 15_000;

/// Share of the vertices that would be samples from which on all of them are, where the caller leaves the choice. At a ratio
/// of 0.2 training meshes above `SMALL` take 1.05 times as long so (median of twelve) and lie an eighth nearer to the original.
const HARDLY_LESS: f64 = 0.45;

/// Simplifies `mesh` to the target of `options`; `progress` hears of every stage and can stop the run.
///
/// `weights` are those of the network; without, those that ship: [`Weights::shipped_default`] for the closed assembly,
/// [`Weights::shipped_paper_open`] for the paper's. With [`ScoreSource::Geometry`] the closed assembly uses none.
///
/// # Errors
/// [`SimplifyError`]: nothing to simplify, options out of range, or stopped by `progress`. A target that cannot be
/// reached is no error: the result is then as small as it can be, and `report.outcome` says what holds it.
///
/// ```
/// use std::ops::ControlFlow;
/// use neural_mesh::mesh::shapes;
/// use neural_mesh::simplify::{Options, ScoreSource, Target, simplify};
/// let mesh = shapes::icosphere(3);
/// let options = Options::new(Target::Vertices(100));
/// let result = simplify(&mesh, None, &options, &mut |_| ControlFlow::Continue(())).unwrap();
/// assert_eq!(result.mesh.positions().len(), 100);
/// // Without a network:
/// let options = Options { scores: ScoreSource::Geometry, ..options };
/// let result = simplify(&mesh, None, &options, &mut |_| ControlFlow::Continue(())).unwrap();
/// assert_eq!(result.report.scores, ScoreSource::Geometry);
/// ```
pub fn simplify(
    mesh: &TriMesh,
    weights: Option<&Weights>,
    options: &Options,
    progress: &mut dyn FnMut(Event) -> ControlFlow<()>,
) -> Result<Simplified, SimplifyError> {
    simplify_input(&Input::bare(mesh), weights, options, progress)
}

/// As [`simplify`], with what the mesh carries: texture coordinates, normals, materials, skins come back with the result,
/// and vertices may count more than others.
///
/// Seams stay seams: no face of the result mixes two groups, or the two sides of an edge where the values jump. The values at
/// a corner are those of the original at the nearest point on the corner's side; texture coordinates and colours are then fitted, so
/// that what the faces blend between their corners is nearest to the original's. The paper's assembly carries nothing.
///
/// # Errors
/// As [`simplify`]; [`SimplifyError::BadInput`] where attributes or importance are not those of the mesh.
///
/// ```
/// use std::ops::ControlFlow;
/// use neural_mesh::mesh::{Attributes, shapes};
/// use neural_mesh::simplify::{Input, Options, Target, simplify_input};
/// let mesh = shapes::icosphere(4);
/// let is_north = |face: &[u32; 3]| face.iter().map(|&v| mesh.positions()[v as usize][2]).sum::<f32>() > 0.0;
/// let groups = mesh.faces().iter().map(|face| u32::from(is_north(face))).collect();
/// let attributes = Attributes { groups, ..Attributes::default() };
/// let input = Input { attributes: &attributes, ..Input::bare(&mesh) };
/// let options = Options::new(Target::Vertices(200));
/// let result = simplify_input(&input, None, &options, &mut |_| ControlFlow::Continue(())).unwrap();
/// assert_eq!(result.attributes.groups.len(), result.mesh.faces().len());
/// ```
pub fn simplify_input(
    input: &Input,
    weights: Option<&Weights>,
    options: &Options,
    progress: &mut dyn FnMut(Event) -> ControlFlow<()>,
) -> Result<Simplified, SimplifyError> {
    run(input, weights, &Task { options, differentiable: false, half: None }, progress)
        .map(|(simplified, _)| simplified)
}

/// Whether a mesh is as small as asked already.
fn is_met_by(mesh: &TriMesh, limit: &Limit) -> bool {
    limit.vertices >= mesh.positions().len() && limit.faces >= mesh.faces().len()
}

/// As [`simplify`], with the record of how the result depends on the positions of the input. Takes longer; the result
/// is the same.
///
/// # Errors
/// As [`simplify`].
///
/// ```
/// use std::ops::ControlFlow;
/// use neural_mesh::mesh::shapes;
/// use neural_mesh::simplify::{Options, Target, simplify_recorded};
/// let mesh = shapes::icosphere(3);
/// let options = Options::new(Target::Vertices(100));
/// let (result, record) =
///     simplify_recorded(&mesh, None, &options, &mut |_| ControlFlow::Continue(())).unwrap();
/// // Where do the input's vertices have to go for vertex 0 of the result to move along x?
/// let mut gradient = vec![[0.0; 3]; 100];
/// gradient[0] = [1.0, 0.0, 0.0];
/// let to_input = record.backward(mesh.positions(), &gradient);
/// // If all of them move along x by 1, so does vertex 0.
/// assert!((to_input.iter().map(|g| g[0]).sum::<f32>() - 1.0).abs() < 1e-3);
/// assert_eq!(record.positions(mesh.positions()).len(), result.mesh.positions().len());
/// ```
pub fn simplify_recorded(
    mesh: &TriMesh,
    weights: Option<&Weights>,
    options: &Options,
    progress: &mut dyn FnMut(Event) -> ControlFlow<()>,
) -> Result<(Simplified, Record), SimplifyError> {
    let task = Task { options, differentiable: true, half: None };
    let (simplified, derivative) = run(&Input::bare(mesh), weights, &task, progress)?;
    let (n_input, n_output) = (mesh.positions().len(), simplified.mesh.positions().len());
    let record = match derivative {
        Some(derivative) => Record::closed(n_input, n_output, derivative),
        None => Record::selected(n_input, simplified.source_vertices.clone().unwrap_or_default()),
    };
    Ok((simplified, record))
}

/// What is asked of a run.
struct Task<'a> {
    options: &'a Options,
    /// Whether the closed result is to be known as a function of the positions.
    differentiable: bool,
    /// Where the mesh is one half of a mirrored one.
    half: Option<Half<'a>>,
}

/// A result of the closed assembly.
struct Made {
    simplified: Simplified,
    /// How it depends on the positions, if that is to be known.
    derivative: Option<Derivative>,
    /// Whether each vertex lies on the plane, where the mesh is one half of a mirrored one.
    on_plane: Vec<bool>,
}

fn run(
    input: &Input,
    weights: Option<&Weights>,
    task: &Task,
    progress: &mut dyn FnMut(Event) -> ControlFlow<()>,
) -> Result<(Simplified, Option<Derivative>), SimplifyError> {
    let options = task.options;
    input.check()?;
    if let Some(symmetry) = options.symmetric {
        let levels = symmetric::levels(input, weights, task, (symmetry, &[options.target]), progress)?;
        return Ok((levels.into_iter().next().ok_or(SimplifyError::Empty)?, None));
    }
    let n_vertices = input.mesh.positions().len();
    let (mesh, sources) = without_unused(input.mesh)?;
    let importance = input.importance_of(sources.as_deref());
    let input = Input { mesh: &mesh, importance: &importance, ..*input };
    let limit = resolve_limit(&mesh, options)?;
    let oversample = resolve_oversample(&mesh, limit, options)?;
    let is_small = is_met_by(&mesh, &limit);
    match options.assembly {
        Assembly::Closed if is_small && is_sound(&mesh, &options.frame) => {
            Ok((from_caller(unchanged(&input, options, oversample), sources, n_vertices), None))
        }
        Assembly::Paper if is_small => {
            Ok((from_caller(unchanged(&input, options, oversample), sources, n_vertices), None))
        }
        Assembly::Closed => {
            let results = closed_results(&input, weights, task, (&[limit], oversample), progress)?;
            let Made { simplified, derivative, .. } = results.into_iter().next().ok_or(SimplifyError::Empty)?;
            let derivative = derivative.map(|derivative| within(derivative, sources.clone()));
            Ok((from_caller(simplified, sources, n_vertices), derivative))
        }
        Assembly::Paper => Ok((paper_result(&mesh, sources, weights, options, limit, progress)?, None)),
    }
}

/// The result with the vertices of the caller's mesh.
fn from_caller(mut simplified: Simplified, sources: Option<Vec<u32>>, n_vertices: usize) -> Simplified {
    if let (Some(map), Some(sources)) = (&mut simplified.map, &sources) {
        map::widen_vertices(map, sources, n_vertices);
    }
    simplified.source_vertices = simplified.source_vertices.map(|kept| through(sources, kept));
    simplified
}

/// The derivative over the vertices of a larger mesh, where `sources` says which those are.
fn within(derivative: Derivative, sources: Option<Vec<u32>>) -> Derivative {
    match sources {
        Some(sources) => derivative.within(&sources),
        None => derivative,
    }
}

/// The closed assembly's result of a mesh and, from where its collapse stood then, those of further limits.
fn closed_results(
    input: &Input,
    weights: Option<&Weights>,
    task: &Task,
    (limits, oversample): (&[Limit], f64),
    progress: &mut dyn FnMut(Event) -> ControlFlow<()>,
) -> Result<Vec<Made>, SimplifyError> {
    let Task { options, differentiable, half } = *task;
    let &[limit, ref further @ ..] = limits else { return Ok(Vec::new()) };
    let n_target = limit.vertices.min(limit.faces / 2 + 2);
    let prune = Prune { for_target: options.prune.then_some(n_target), below: options.prune_below };
    let pruned = if options.prune || prune.below > 0.0 { pruned(input.mesh, &prune) } else { None };
    let left = pruned.as_ref().map(|pruned| input.part(&pruned.sources, &pruned.faces)).transpose()?;
    let mesh = pruned.as_ref().map_or(input.mesh, |pruned| &pruned.mesh);
    let (attributes, factors) = left.as_ref().map_or((input.attributes, input.importance), |left| (&left.0, &left.1));
    let importance = match options.scores {
        _ if !factors.is_empty() => Importance::Given(factors),
        ScoreSource::Network => Importance::Network(weights.unwrap_or_else(|| Weights::shipped_default())),
        ScoreSource::Geometry => Importance::Even,
    };
    let edges = input::kept_edges(mesh, attributes, options);
    let locked = input::locked_vertices(mesh, options);
    let attributes = Some(attributes).filter(|attributes| !attributes.is_empty());
    let keep = Keep { edges: &edges, locked: &locked, subset: options.subset, attributes, map: options.map, half };
    let (parts, seed, frame) = (Parts::default(), options.seed, options.frame);
    let all_if_uneven = options.oversample.is_none();
    let request = Request { limit, oversample, all_if_uneven, importance, parts, seed, frame, differentiable, keep };
    let levels = simplify_levels(mesh, &request, further, progress)?;
    let sources = pruned.as_ref().map(|pruned| &pruned.sources);
    let told = |mut closed: Closed| {
        let report = Report {
            outcome: outcome(closed.end),
            components_pruned: pruned.as_ref().map_or(0, |pruned| pruned.n_dropped),
            kept_edges: edges.len(),
            locked_vertices: locked.iter().filter(|&&locked| locked).count(),
            ..closed_report(&closed, options)
        };
        let derivative = closed.derivative.take().map(|derivative| within(derivative, sources.cloned()));
        let corner_map = closed.corner_map.take();
        let map =
            corner_map.map(|corners| map::of_pruned(map::of(mesh, &closed, corners), input.mesh, pruned.as_ref()));
        let source_vertices = closed.source_vertices.map(|kept| through(sources.cloned(), kept));
        let Closed { mesh, attributes, on_plane, .. } = closed;
        Made { simplified: Simplified { mesh, attributes, source_vertices, map, report }, derivative, on_plane }
    };
    Ok(levels.into_iter().map(told).collect())
}

fn paper_result(
    mesh: &TriMesh,
    sources: Option<Vec<u32>>,
    weights: Option<&Weights>,
    options: &Options,
    limit: Limit,
    progress: &mut dyn FnMut(Event) -> ControlFlow<()>,
) -> Result<Simplified, SimplifyError> {
    let weights = weights.unwrap_or_else(|| Weights::shipped_paper_open());
    let n_target = limit.vertices.min((limit.faces / 2).max(3));
    let result = paper::simplify_paper(mesh, n_target, weights, options.seed, progress)?;
    let (lighter, kept) = compact(mesh.positions(), result.faces).map_err(|_| SimplifyError::Overflow)?;
    let report = plain_report(&lighter, options);
    let source_vertices = Some(through(sources, kept));
    Ok(Simplified { mesh: lighter, attributes: Attributes::default(), source_vertices, map: None, report })
}

/// The mesh as it is, for targets that it meets already.
fn unchanged(input: &Input, options: &Options, oversample: f64) -> Simplified {
    let mesh = input.mesh;
    let all = (0..mesh.positions().len() as u32).collect();
    let report = Report { oversample, ..plain_report(mesh, options) };
    let source_vertices = Some(all);
    let map = options.map.then(|| map::of_unchanged(mesh));
    Simplified { mesh: mesh.clone(), attributes: input.attributes.clone(), source_vertices, map, report }
}

/// Vertices of the caller's mesh for vertices of the one without unused vertices.
fn through(sources: Option<Vec<u32>>, kept: Vec<u32>) -> Vec<u32> {
    match sources {
        Some(sources) => kept.into_iter().map(|v| sources[v as usize]).collect(),
        None => kept,
    }
}

/// The mesh without vertices that no face uses, and where the others stood if any went.
fn without_unused(mesh: &TriMesh) -> Result<(Cow<'_, TriMesh>, Option<Vec<u32>>), SimplifyError> {
    if mesh.faces().is_empty() {
        return Err(SimplifyError::Empty);
    }
    let used: Vec<AtomicBool> = (0..mesh.positions().len()).map(|_| AtomicBool::new(false)).collect();
    let mark = |face: &[u32; 3]| face.iter().for_each(|&v| used[v as usize].store(true, Relaxed));
    mesh.faces().par_iter().with_min_len(crate::mesh::shares::PARALLEL).for_each(mark);
    if used.into_iter().all(AtomicBool::into_inner) {
        return Ok((Cow::Borrowed(mesh), None));
    }
    let (mesh, sources) = compact(mesh.positions(), mesh.faces().to_vec()).map_err(|_| SimplifyError::Overflow)?;
    Ok((Cow::Owned(mesh), Some(sources)))
}

fn outcome(end: End) -> Outcome {
    match end {
        End::Reached => Outcome::Reached,
        End::Smallest => Outcome::Stopped("every component is as small as its topology allows".into()),
        End::Held => Outcome::Stopped("seams, creases or locked vertices hold what is left".into()),
        End::WouldTurn => Outcome::Stopped("no edge is left that could go without turning a face over".into()),
    }
}

fn closed_report(closed: &Closed, options: &Options) -> Report {
    Report {
        oversample: closed.oversample,
        vertices_after_pass: closed.vertices_after_pass,
        split_vertices: closed.split_vertices,
        refined_regions: closed.refined_regions,
        flipped_edges: closed.flipped_edges,
        separated_vertices: closed.separated_vertices,
        ..plain_report(&closed.mesh, options)
    }
}

/// The report of a result to which nothing else was done.
fn plain_report(mesh: &TriMesh, options: &Options) -> Report {
    Report {
        outcome: Outcome::Reached,
        scores: match options.assembly {
            Assembly::Closed => options.scores,
            Assembly::Paper => ScoreSource::Network,
        },
        oversample: 1.0,
        vertices_after_pass: mesh.positions().len(),
        components_at_minimum: count_components(mesh).1,
        components_pruned: 0,
        kept_edges: 0,
        locked_vertices: 0,
        split_vertices: 0,
        refined_regions: 0,
        flipped_edges: 0,
        separated_vertices: 0,
        mirror: None,
    }
}

fn resolve_oversample(mesh: &TriMesh, limit: Limit, options: &Options) -> Result<f64, SimplifyError> {
    match options.oversample {
        Some(oversample) if !(1.0..=4.0).contains(&oversample) => Err(SimplifyError::BadOversample(oversample)),
        Some(oversample) => Ok(oversample),
        None => Ok(default_oversample(mesh, limit)),
    }
}

/// Samples per vertex asked for, where the caller leaves the choice.
fn default_oversample(mesh: &TriMesh, limit: Limit) -> f64 {
    let ratio = ratio(mesh, limit);
    let of_pass = oversample_of_pass(ratio);
    let is_all = mesh.positions().len() <= SMALL || of_pass * ratio >= HARDLY_LESS;
    if is_all { (1.0 / ratio).max(1.0) } else { of_pass }
}

/// The share of the vertices that a limit leaves.
fn ratio(mesh: &TriMesh, limit: Limit) -> f64 {
    limit.size() as f64 / mesh.positions().len() as f64
}

/// Samples per vertex asked for where the one pass does most of the work.
fn oversample_of_pass(ratio: f64) -> f64 {
    (OVERSAMPLE / ratio.cbrt()).clamp(1.0, 4.0)
}

/// The target as numbers of vertices and faces.
fn resolve_limit(mesh: &TriMesh, options: &Options) -> Result<Limit, SimplifyError> {
    match options.target {
        Target::Ratio(ratio) if ratio > 0.0 && ratio <= 1.0 => {
            let vertices = ((mesh.positions().len() as f64 * ratio) as usize).max(1);
            Ok(Limit { vertices, faces: usize::MAX })
        }
        Target::Vertices(vertices) if vertices > 0 => Ok(Limit { vertices, faces: usize::MAX }),
        Target::Faces(faces) if faces > 0 => Ok(Limit { vertices: usize::MAX, faces }),
        _ => Err(SimplifyError::BadTarget(options.target)),
    }
}
