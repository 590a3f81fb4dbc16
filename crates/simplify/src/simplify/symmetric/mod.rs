//! Symmetric results: one half is simplified, open along the plane, and joined with its image.

mod cut;
mod doubled_attributes;
mod image_plane;
mod joined_halves;
mod mirror_pairs;
mod unpaired_faces;

use crate::mesh::pulse::Pulse;
use crate::mesh::{Frame, TriMesh};

use super::assemblies::simplify_closed;
use super::closed::{ClosedResult, Levels, Task};
use super::components::count_components;
use super::input::{Half, Input};
use super::limits::resolve_levels;
use super::options::{ClosedOptions, Hidden, Optimize, Purpose, Report, Simplified, SimplifyError, Symmetry, Target};
use super::progress::Progress;
use super::sub_mesh::SubMesh;
use doubled_attributes::GroupPairs;
use image_plane::ImagePlane;
use joined_halves::SimplifiedHalf;
use mirror_pairs::MirrorPairs;

pub(super) fn simplify_symmetric(
    task: &Task,
    symmetry: Symmetry,
    targets: &[Target],
    progress: Progress,
) -> Result<Vec<Simplified>, SimplifyError> {
    let input = &task.input;
    check(task)?;
    progress.enter("symmetry", input.mesh.faces().len())?;
    let used = SubMesh::without_unused_vertices(progress.pulse, input)?;
    let Input { mesh, attributes, importance, .. } = used.input();
    let limits = resolve_levels(mesh, targets)?;
    let frame = &task.options.frame;
    let (plane, pairs) = find_mirror_plane(mesh, symmetry, frame)?;
    // Corners of the half carry both sides' values through the simplification.
    let (attributes, groups) = doubled_attributes::double_attributes(attributes, &pairs);
    let mut half = cut::cut((mesh, attributes, importance), &plane, &pairs)?;
    doubled_attributes::add_joints(&mut half.attributes, half.mesh.faces(), &half.on_plane);
    let of_half = Input {
        attributes: &half.attributes,
        importance: &half.importance,
        half: Some(Half { axis: plane.axis, on_plane: &half.on_plane }),
        ..Input::bare(&half.mesh)
    };
    // Sizes are those of the whole mesh: the collapse counts both halves.
    let halves = simplify_closed(&Task { input: of_half, ..*task }, Levels::new(&limits), progress)?;
    halves.into_iter().map(|half| join_halves(half, &plane, &groups, task.options)).collect()
}

fn find_mirror_plane(
    mesh: &TriMesh,
    symmetry: Symmetry,
    frame: &Frame,
) -> Result<(ImagePlane, MirrorPairs), SimplifyError> {
    let mut refused = None;
    // If no plane works, the error of the first one is reported.
    for plane in image_plane::find_planes(mesh, symmetry, frame) {
        match MirrorPairs::new(mesh, &plane, frame) {
            Ok(pairs) => return Ok((plane, pairs)),
            Err(error) => refused = refused.or(Some(error)),
        }
    }
    Err(refused.unwrap_or(SimplifyError::Empty))
}

fn check(task: &Task) -> Result<(), SimplifyError> {
    let Task { input, options, .. } = *task;
    let refused = [
        ("locked boundaries", options.lock_boundaries),
        ("a subset of the vertices", options.subset),
        ("faces that are kept", !input.kept.is_empty()),
        ("vertices that are locked", !input.locked.is_empty()),
        ("pruning", options.prune_below > 0.0),
        ("hidden components dropped", options.hidden != Hidden::Keep),
        // A half shows its inside through the cut.
        ("optimization of looks", options.optimize == Optimize::Looks),
        ("a map", options.map),
        ("a purpose other than shape", options.purpose != Purpose::Shape),
        ("a record", task.differentiable),
    ];
    match refused.into_iter().find(|(_, is_asked)| *is_asked) {
        Some((what, _)) => Err(SimplifyError::NotWithSymmetry(what)),
        None => Ok(()),
    }
}

fn join_halves(
    half: ClosedResult,
    plane: &ImagePlane,
    groups: &GroupPairs,
    options: &ClosedOptions,
) -> Result<Simplified, SimplifyError> {
    let ClosedResult { simplified: Simplified { mesh, attributes, report, .. }, on_plane, .. } = half;
    let half = SimplifiedHalf { mesh: &mesh, attributes, on_plane: &on_plane };
    let (mesh, attributes, separated_vertices) = joined_halves::join_half(half, plane, groups, &options.frame)?;
    // Most counts are those of one half; components and duplicates are counted in the whole mesh.
    let report = Report {
        separated_vertices,
        components_at_minimum: count_components(Pulse::NONE, &mesh).1,
        mirror: Some(plane.in_file(&options.frame)),
        ..report
    };
    Ok(Simplified { mesh, attributes, source_vertices: None, map: None, report })
}
