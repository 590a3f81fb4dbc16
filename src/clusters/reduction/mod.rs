//! Simplification of the faces of a group.

mod double_faces;
mod sparse_components;
mod vertex_clustering;

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use crate::mesh::{Attributes, TriMesh};
use crate::simplify::{ClosedOptions, Hidden, Input, SimplifyError, Size, simplify_forcing_size};

use super::vertices::{Patch, ReducedPatch};
use double_faces::{PartedPatch, add_leaves, part_double_faces};
use sparse_components::{count_leaf_faces, drop_components};
use vertex_clustering::cluster_vertices;

/// Faces of a result over the wanted number at which the next, coarser method is tried.
const FAR_FROM_TARGET: f64 = 1.3;

/// Largest deformation of a component, over the diagonal of its group.
const HELD_SHAPE: f64 = 0.01;

/// Returns options for groups: all surfaces and components stay.
pub fn options_for_groups(options: &ClosedOptions) -> ClosedOptions {
    ClosedOptions {
        hidden: Hidden::Keep,
        prune: false,
        prune_below: 0.0,
        // Charts and materials of a group must fit those of its neighbours.
        hold_shape: Some(HELD_SHAPE),
        map: false,
        ..options.clone()
    }
}

/// Returns options by which components bend further, and go where a viewer loses less by that.
// Silhouettes of a ufo and a building of 36 and 74 components, at a 64th: intersection over union 0.90 and 0.97; where
// components went by their area instead, 0.80 and 0.79.
fn options_for_coarse_shapes(options: &ClosedOptions) -> ClosedOptions {
    ClosedOptions { hold_shape: None, prune: true, ..options.clone() }
}

/// Simplifies a patch to about `n_faces`.
///
/// If shapes prevent it, they are made coarser and components are dropped by what is seen of them, then by their area;
/// then vertices are joined.
///
/// # Errors
/// [`SimplifyError::Interrupted`] once `stops` is set.
pub fn reduce(
    patch: &Patch,
    options: &ClosedOptions,
    n_faces: usize,
    stops: &AtomicBool,
) -> Result<ReducedPatch, SimplifyError> {
    let PartedPatch { for_collapse, leaves } = part_double_faces(patch);
    let n_without_leaves = (n_faces - n_faces * leaves.len() / patch.mesh.faces().len()).max(1);
    let is_far = |reduced: &ReducedPatch| reduced.mesh.faces().len() as f64 > FAR_FROM_TARGET * n_faces as f64;
    let mut reduced = ReducedPatch { mesh: patch.mesh.clone(), attributes: patch.attributes.clone() };
    if let Some(rest) = &for_collapse {
        reduced = add_leaves(collapse(rest, options, n_without_leaves, stops)?, patch, &leaves);
        // Leaves make room by growing instead.
        let n_leaves = || leaves.len() + count_leaf_faces(&rest.0, &patch.locked_positions());
        if is_far(&reduced) && 2 * n_leaves() < patch.mesh.faces().len() {
            let coarse = collapse(rest, &options_for_coarse_shapes(options), n_without_leaves, stops)?;
            reduced = add_leaves(coarse, patch, &leaves);
        }
    }
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
    (mesh, attributes, locked): &(TriMesh, Attributes, Vec<bool>),
    options: &ClosedOptions,
    n_faces: usize,
    stops: &AtomicBool,
) -> Result<ReducedPatch, SimplifyError> {
    let mut input = Input::bare(mesh);
    (input.attributes, input.locked) = (attributes, locked);
    let mut go_on = |_| if stops.load(Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    match simplify_forcing_size(&input, options, Size::Faces(n_faces), &mut go_on) {
        Ok(made) => Ok(ReducedPatch { mesh: made.mesh, attributes: made.attributes }),
        Err(SimplifyError::Interrupted) => Err(SimplifyError::Interrupted),
        // What the collapse refuses, such as coordinates at the limit of single precision, is left to the other methods.
        Err(_) => Ok(ReducedPatch { mesh: mesh.clone(), attributes: attributes.clone() }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clusters::vertices::VertexPool;
    use crate::mesh::{edges, shapes};

    #[test]
    fn double_faces_do_not_open_the_surface() {
        // A sphere, and a triangle whose other side is a face of its own.
        let sphere = shapes::icosphere(3);
        let n = sphere.positions().len() as u32;
        let far = [[3.0, 0.0, 0.0], [4.0, 0.0, 0.0], [3.0, 1.0, 0.0]];
        let positions = sphere.positions().iter().copied().chain(far).collect();
        let double = [[n, n + 1, n + 2], [n, n + 2, n + 1]];
        let mesh = TriMesh::new(positions, sphere.faces().iter().copied().chain(double).collect()).unwrap();
        let (pool, faces) = VertexPool::new(&Input::bare(&mesh));
        let patch = pool.patch(&faces, |place| place >= n).unwrap();
        let reduced = reduce(&patch, &ClosedOptions::default(), 320, &AtomicBool::new(false)).unwrap();
        assert!(edges(&reduced.mesh).iter().all(|edge| edge.n_faces() == 2));
        assert!((300..=340).contains(&reduced.mesh.faces().len()), "{}", reduced.mesh.faces().len());
    }
}
