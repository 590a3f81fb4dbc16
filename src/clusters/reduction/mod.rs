//! Simplification of the faces of a group.

mod sparse_components;
mod vertex_clustering;

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use crate::simplify::{ClosedOptions, Hidden, Input, SimplifyError, Target, simplify_forcing_size};

use super::vertices::{Patch, ReducedPatch};
use sparse_components::drop_components;
use vertex_clustering::cluster_vertices;

/// Faces of a result over the wanted number at which the next, coarser method is tried.
const FAR_FROM_TARGET: f64 = 1.3;

/// Returns options for groups: all surfaces and components stay.
pub fn options_for_groups(options: &ClosedOptions) -> ClosedOptions {
    ClosedOptions {
        hidden: Hidden::Keep,
        prune: false,
        prune_below: 0.0,
        symmetric: None,
        map: false,
        ..options.clone()
    }
}

/// Simplifies a patch to about `n_faces`; if components or handles prevent it, drops components, then joins vertices.
///
/// # Errors
/// [`SimplifyError::Interrupted`] once `stops` is set.
pub fn reduce(
    patch: &Patch,
    options: &ClosedOptions,
    n_faces: usize,
    stops: &AtomicBool,
) -> Result<ReducedPatch, SimplifyError> {
    let reduced = collapse(patch, options, n_faces, stops)?;
    let is_far = |reduced: &ReducedPatch| reduced.mesh.faces().len() as f64 > FAR_FROM_TARGET * n_faces as f64;
    if !is_far(&reduced) {
        return Ok(reduced);
    }
    let reduced = drop_components(reduced, &patch.locked_positions(), n_faces);
    if !is_far(&reduced) {
        return Ok(reduced);
    }
    Ok(cluster_vertices(reduced, &patch.locked_positions(), n_faces))
}

fn collapse(
    patch: &Patch,
    options: &ClosedOptions,
    n_faces: usize,
    stops: &AtomicBool,
) -> Result<ReducedPatch, SimplifyError> {
    let mut input = Input::bare(&patch.mesh);
    (input.attributes, input.locked) = (&patch.attributes, &patch.locked);
    let mut go_on = |_| if stops.load(Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    match simplify_forcing_size(&input, None, options, Target::Faces(n_faces), &mut go_on) {
        Ok(made) => Ok(ReducedPatch { mesh: made.mesh, attributes: made.attributes }),
        Err(SimplifyError::Interrupted) => Err(SimplifyError::Interrupted),
        // What the collapse refuses, such as coordinates at the limit of single precision, is left to the other methods.
        Err(_) => Ok(ReducedPatch { mesh: patch.mesh.clone(), attributes: patch.attributes.clone() }),
    }
}
