//! The closed assembly, ours: samples, regions, quotient, collapse, flips and fit. Closed in, closed out.

mod attributes;
mod beneath;
mod cluster;
mod collapse;
mod derivative;
mod nearest;
mod pins;
mod prepare;
mod refine;

use std::ops::ControlFlow;

use glam::Vec3;
use rayon::prelude::*;

use crate::mesh::shares::PARALLEL;
use crate::mesh::{Attributes, Frame, TriMesh, topology};
use crate::model::Weights;

use super::options::{Event, Parts, SimplifyError};
use attributes::corners::Corners;
use cluster::darts::{self, Assignment};
use cluster::edge_lengths::EdgeLengths;
use cluster::placement::{self, Case};
use cluster::sums::{self, Sum};
use cluster::{cuts, importance, quotient};
use collapse::constraints::Holds;
use collapse::{Collapse, Merge, Remains};
use derivative::Choices;
use pins::OnPlane;
use prepare::features::Features;
use prepare::surface::Surface;
use prepare::uneven;
use refine::points::Points;
use refine::{duplicate_positions, fit, flips, foldovers};

pub(super) use attributes::corners::{CornerMap, blend};
pub use cluster::importance::importance_of_scores;
pub(super) use collapse::{End, Limit};
pub(super) use derivative::Derivative;
pub(super) use pins::Half;
pub(super) use refine::duplicate_positions::separate_twins;

/// Input vertices per output vertex from which on flips pay: nearer to the original's own size, the collapse has seen to
/// the diagonals.
const COARSE: usize = 15;
/// Share of the samples that are darts; the rest is for cutting regions that cost too much.
const DARTS: f64 = 0.9;
/// How much an edge that stays counts against the surface: weight of the plane that stands on it.
const EDGE_WEIGHT: f32 = 0.3;
/// Above this share of the vertices the samples are all vertices.
const NEARLY_ALL: f64 = 0.9;

/// What the closed assembly is asked.
pub(super) struct Request<'a> {
    /// The size to reach.
    pub limit: Limit,
    /// Samples per vertex asked for.
    pub oversample: f64,
    /// Whether all vertices are samples where the surface is uneven.
    pub all_if_uneven: bool,
    /// How much more than its area each vertex of the mesh counts.
    pub importance: Importance<'a>,
    /// What is done beside the darts, quotient and collapse.
    pub parts: Parts,
    /// Seed of the darts.
    pub seed: u64,
    /// How the result will be written.
    pub frame: Frame,
    /// Whether the result is to be known as a function of the positions.
    pub differentiable: bool,
    /// What has to stay.
    pub keep: Keep<'a>,
}

/// What has to stay of a mesh beside its shape.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Keep<'a> {
    /// Edges that stay edges, over vertices of the mesh: seams and creases.
    pub edges: &'a [[u32; 2]],
    /// Whether each vertex stays where it is; empty where all may go.
    pub locked: &'a [bool],
    /// Whether the vertices of the result have to be vertices of the mesh.
    pub subset: bool,
    /// What corners and faces carry.
    pub attributes: Option<&'a Attributes>,
    /// Whether it is to be known where on the mesh the result's corners stand.
    pub map: bool,
    /// Where the mesh is one half of a mirrored one; then sizes are those of the whole.
    pub half: Option<Half<'a>>,
}

/// How much more than its area each vertex counts.
#[derive(Clone, Copy, Debug)]
pub enum Importance<'a> {
    /// All count alike.
    Even,
    /// From the Point Sampler of this network.
    Network(&'a Weights),
    /// One positive factor per vertex of the mesh.
    Given(&'a [f32]),
}

/// What the closed assembly gives.
pub(super) struct Closed {
    /// The lighter mesh.
    pub mesh: TriMesh,
    /// How the collapse ended.
    pub end: End,
    /// Samples per vertex asked for.
    pub oversample: f64,
    /// Vertices after the one pass.
    pub vertices_after_pass: usize,
    /// Vertices split where sheets met.
    pub split_vertices: usize,
    /// Regions cut to keep the surface a manifold.
    pub refined_regions: usize,
    /// Edges flipped.
    pub flipped_edges: usize,
    /// For each vertex of the mesh the output vertex that its region became.
    pub vertex_of: Vec<u32>,
    /// Vertices moved apart for the file.
    pub separated_vertices: usize,
    /// The result as a function of the positions, where that was asked for.
    pub derivative: Option<Derivative>,
    /// What the corners and faces of the result carry.
    pub attributes: Attributes,
    /// Where on the mesh the corners stand, if that was to be known.
    pub corner_map: Option<CornerMap>,
    /// The vertex of the mesh that each output vertex is, where they were to be such.
    pub source_vertices: Option<Vec<u32>>,
    /// Whether each output vertex lies on the plane, where the mesh is one half of a mirrored one; else empty.
    pub on_plane: Vec<bool>,
}

/// Simplifies `mesh` to the limit of the request.
pub(super) fn simplify_closed(
    mesh: &TriMesh,
    request: &Request,
    progress: &mut dyn FnMut(Event) -> ControlFlow<()>,
) -> Result<Closed, SimplifyError> {
    simplify_levels(mesh, request, &[], progress)?.pop().ok_or(SimplifyError::Empty)
}

/// Simplifies `mesh` to the limit of the request, then on to each of the further limits, from where the collapse stood
/// before. Only the last level is known as a function of the positions.
pub(super) fn simplify_levels(
    mesh: &TriMesh,
    request: &Request,
    further: &[Limit],
    progress: &mut dyn FnMut(Event) -> ControlFlow<()>,
) -> Result<Vec<Closed>, SimplifyError> {
    let mut enter = |stage| match progress(Event { stage, done: 0.0 }) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(SimplifyError::Interrupted),
    };
    let (begun, collapse) = begin(mesh, request, &mut enter)?;
    let mut collapse = Some(collapse);
    let mut levels = Vec::with_capacity(1 + further.len());
    for &limit in [request.limit].iter().chain(further) {
        // The last level needs the memory of the collapse for itself.
        let Some(mut running) = collapse.take() else { break };
        if !levels.is_empty() {
            enter("collapse")?;
        }
        let end = running.run(limit);
        let (merges, remains) = (running.history.take(), running.remains());
        collapse = (levels.len() < further.len()).then_some(running);
        levels.push(finished(&begun, request, Collapsed { end, merges, remains }, &mut enter)?);
    }
    Ok(levels)
}

/// A mesh as the collapse finds it, and how it came to that.
struct Begun<'a> {
    mesh: &'a TriMesh,
    surface: Surface<'a>,
    features: Features,
    oversample: f64,
    assignment: Assignment,
    n_refined: usize,
    /// How the regions' vertices were placed, where that has to be known.
    cases: Option<Vec<Case>>,
}

/// What a collapse left.
struct Collapsed {
    end: End,
    merges: Option<Vec<Merge>>,
    remains: Remains,
}

/// The one pass, up to the collapse of what it leaves.
fn begin<'a>(
    mesh: &'a TriMesh,
    request: &Request,
    enter: &mut dyn FnMut(&'static str) -> Result<(), SimplifyError>,
) -> Result<(Begun<'a>, Collapse), SimplifyError> {
    enter("surface")?;
    let mut surface = Surface::new(mesh);
    let Keep { edges, locked, subset, half, .. } = request.keep;
    let on_plane = half.map(|half| OnPlane::of(&surface, &half));
    let mut features = Features::on(&surface, edges, locked, subset);
    features.on_plane = on_plane;
    surface.support_edges(&features.edges, EDGE_WEIGHT);
    features.on_plane.iter().for_each(|on_plane| on_plane.complete(&mut surface));
    enter("samples")?;
    let oversample = oversample(&surface, request);
    let n_samples = n_samples(&surface, request, oversample);
    let mut assignment = samples(&surface, request, n_samples);
    enter("scores")?;
    importance::weigh(&mut surface, &assignment, request.importance);
    enter("cuts")?;
    let mut sums = cut_costly(&surface, &mut assignment, n_samples);
    enter("quotient")?;
    if features.set_apart(&mut assignment) {
        sums = sums::sums(&surface, &assignment);
    }
    let quotient = quotient::quotient(&surface, &features, &mut assignment, &mut sums);
    enter("placement")?;
    let mut placed = placement::place(&surface, &assignment, &sums, &quotient.faces);
    let holds = holds(&surface, &features, &assignment, &mut placed);
    let wanted = request.differentiable;
    let cases = wanted.then(|| placement::cases(&assignment, &placed));
    enter("collapse")?;
    let of_colours = |attributes| collapse::of_colours((mesh, &surface), &features, &assignment, &placed, attributes);
    let colours = request.keep.attributes.map(of_colours).unwrap_or_default();
    let collapse = if wanted || holds.is_some() || !colours.is_empty() {
        let mut collapse = Collapse::new(&placed, &quotient.rings);
        (collapse.history, collapse.holds, collapse.colours) = (wanted.then(Vec::new), holds, colours);
        collapse
    } else {
        Collapse::toward(request.limit, &placed, &quotient.rings)
    };
    let n_refined = quotient.n_refined;
    // Nothing that follows asks for these.
    (surface.quadrics, assignment.samples) = (Vec::new(), Vec::new());
    Ok((Begun { mesh, surface, features, oversample, assignment, n_refined, cases }, collapse))
}

/// What follows the collapse: flips, fit, folds, and what the corners carry.
fn finished(
    begun: &Begun,
    request: &Request,
    collapsed: Collapsed,
    enter: &mut dyn FnMut(&'static str) -> Result<(), SimplifyError>,
) -> Result<Closed, SimplifyError> {
    let Begun { mesh, surface, features, assignment, .. } = begun;
    let Collapsed { end, merges, mut remains } = collapsed;
    let Keep { subset, attributes, map, .. } = request.keep;
    let attributes = attributes.or(map.then_some(Attributes::NONE));
    enter("flips")?;
    let became = |&region: &u32| remains.vertex_of[region as usize];
    let vertex_of: Vec<u32> = assignment.region.par_iter().with_min_len(PARALLEL).map(became).collect();
    let coarse = COARSE * remains.positions.len() <= surface.n_vertices();
    let carrying = |attributes| Corners::new(surface, features, attributes, &vertex_of, &remains.faces);
    let mut corners = attributes.map(carrying);
    let mut points = Points::new(surface, &vertex_of, remains.positions.len());
    let flips = coarse && request.parts.flips;
    let flipped_edges = if flips { flips::flip(&mut points, &mut remains, corners.as_mut()) } else { 0 };
    enter("fit")?;
    let Remains { mut positions, mut faces, normals, vertex_of: output_of, fixed, origins, on_plane } = remains;
    let mut output = fit::Output {
        positions: &mut positions,
        faces: &faces,
        meant: &normals,
        fixed: &fixed,
        on_plane: on_plane.as_ref(),
        has_curves: !features.edges.is_empty(),
    };
    let mut steps = merges.as_ref().map(|_| Vec::new());
    if request.parts.fit && !subset {
        fit::fit(&mut points, &mut output, steps.as_mut());
    }
    let fitted = merges.as_ref().map(|_| faces.clone());
    enter("finish")?;
    let (positions_now, corners_now) = (&mut positions, corners.as_mut());
    let mut folded = foldovers::Folded {
        positions: positions_now,
        faces: &mut faces,
        corners: corners_now,
        fixed: &fixed,
        on_plane: on_plane.as_ref(),
        is_coarse: coarse,
    };
    let flipped_edges = flipped_edges + foldovers::unfold(surface, &vertex_of, &mut folded);
    let is_on_plane = |x: usize| on_plane.as_ref().is_some_and(|on_plane| on_plane.has(x as u32));
    let is_fixed = |x: usize| fixed.get(x).is_some_and(|&fixed| fixed);
    let carried = corners.zip(attributes).map(|(corners, attributes)| {
        let stays: Vec<bool> = (0..positions.len()).map(|x| is_fixed(x) || is_on_plane(x)).collect();
        corners.attributes((mesh, surface), features, attributes, (&positions, &stays))
    });
    let (attributes, corner_map) = carried.unzip();
    let attributes = attributes.unwrap_or_default();
    let local = |p: &Vec3| surface.scale.restore(p.as_dvec3());
    let mut positions: Vec<[f32; 3]> = positions.par_iter().with_min_len(PARALLEL).map(local).collect();
    let source_vertices: Vec<u32> = origins.iter().map(|&v| surface.source(v)).collect();
    let in_place = (0..source_vertices.len()).filter(|&x| subset || fixed[x]);
    in_place.for_each(|x| positions[x] = mesh.positions()[source_vertices[x] as usize]);
    // The halves of a mirrored mesh come apart together.
    let stay = subset || on_plane.is_some();
    let separated_vertices =
        if stay { 0 } else { duplicate_positions::separate(&mut positions, &fixed, &request.frame) };
    let derivative = match (&begun.cases, merges, fitted, steps) {
        (Some(cases), Some(merges), Some(faces), Some(steps)) => {
            let (region, cases) = (assignment.region.clone(), cases.clone());
            let choices = Choices { region, cases, merges, output_of, faces, steps };
            Some(Derivative::new(surface, choices, mesh.positions(), &positions))
        }
        _ => None,
    };
    Ok(Closed {
        mesh: TriMesh::new(positions, faces).map_err(|_| SimplifyError::Overflow)?,
        end,
        oversample: begun.oversample,
        vertices_after_pass: assignment.n_regions,
        split_vertices: surface.n_split(),
        refined_regions: begun.n_refined,
        flipped_edges,
        vertex_of,
        separated_vertices,
        derivative,
        attributes,
        corner_map: corner_map.filter(|_| map),
        source_vertices: subset.then_some(source_vertices),
        on_plane: on_plane.map(OnPlane::into_flags).unwrap_or_default(),
    })
}

/// What holds the collapse back; in the end the regions' vertices lie where they have to.
fn holds(
    surface: &Surface,
    features: &Features,
    assignment: &Assignment,
    placed: &mut placement::Placement,
) -> Option<Holds> {
    if features.is_empty() {
        return None;
    }
    let mut origins = vec![0; assignment.n_regions];
    (0u32..).zip(&assignment.region).for_each(|(v, &r)| origins[r as usize] = v);
    if features.subset {
        origins = placement::to_own_vertices(surface, assignment, placed);
    }
    let locked = (0..features.locked.len()).filter(|&v| features.locked[v]);
    placed.move_to_vertices(locked.map(|v| (assignment.region[v], v as u32)));
    Some(Holds::new(features, &assignment.region, origins))
}

/// Whether a mesh is already what the assembly promises: a manifold, wound one way, no two vertices in one place.
pub(super) fn is_sound(mesh: &TriMesh, frame: &Frame) -> bool {
    let topology = topology(mesh);
    topology.non_manifold_edges + topology.non_manifold_vertices + topology.inconsistent_edges == 0
        && duplicate_positions::are_apart(mesh.positions(), frame)
}

/// Samples per vertex asked for; as many as there are vertices where the surface asks for that.
fn oversample(surface: &Surface, request: &Request) -> f64 {
    let all = surface.n_vertices() as f64 / request.limit.size() as f64;
    if request.all_if_uneven && all > request.oversample && uneven::is_uneven(surface) {
        all
    } else {
        request.oversample
    }
}

/// How many samples that comes to; all vertices where nearly all are wanted.
fn n_samples(surface: &Surface, request: &Request, oversample: f64) -> usize {
    let wanted = request.limit.size() as f64 * oversample;
    let wanted = wanted.max(least_samples(surface, request.limit) as f64);
    let nearly_all = wanted >= NEARLY_ALL * surface.n_vertices() as f64;
    // Regions could meet across the plane of a half.
    if nearly_all || request.keep.half.is_some() { surface.n_vertices() } else { wanted as usize }
}

/// The samples below which the one pass could end under the limit: a vertex less is two faces less at most.
fn least_samples(surface: &Surface, Limit { vertices, faces }: Limit) -> usize {
    let excess_faces = surface.faces.len().saturating_sub(faces);
    vertices.min(surface.n_vertices().saturating_sub(excess_faces / 2)).max(4)
}

/// Throws the darts, or takes every vertex where all are wanted.
fn samples(surface: &Surface, request: &Request, n_samples: usize) -> Assignment {
    if n_samples >= surface.n_vertices() {
        return Assignment::identity(surface.n_vertices());
    }
    let lengths = EdgeLengths::new(surface);
    let n_darts = ((n_samples as f64 * DARTS) as usize).max(least_samples(surface, request.limit));
    darts::throw_darts(surface, &lengths, n_darts, request.seed)
}

/// Cuts regions that cost too much. Returns the sums of the regions; none where every vertex is one.
fn cut_costly(surface: &Surface, assignment: &mut Assignment, n_samples: usize) -> Vec<Sum> {
    if assignment.n_regions == surface.n_vertices() {
        return Vec::new();
    }
    let mut sums = sums::sums(surface, assignment);
    cuts::cut_costly(surface, assignment, &mut sums, n_samples);
    sums
}
