//! Simplification of the faces of a group.

mod sparse_components;
mod vertex_clustering;

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use crate::mesh::{Attributes, TriMesh, compact};
use crate::simplify::{ClosedOptions, Hidden, Input, SimplifyError, Target, simplify_forcing_size};

use super::vertices::{Patch, ReducedPatch};
use sparse_components::drop_components;
use vertex_clustering::{cluster_vertices, distinct_faces};

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
    let unchanged = || ReducedPatch { mesh: patch.mesh.clone(), attributes: patch.attributes.clone() };
    let Some((mesh, attributes, locked)) = without_double_faces(patch) else { return Ok(unchanged()) };
    let mut input = Input::bare(&mesh);
    (input.attributes, input.locked) = (&attributes, &locked);
    let mut go_on = |_| if stops.load(Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    match simplify_forcing_size(&input, None, options, Target::Faces(n_faces), &mut go_on) {
        Ok(made) => Ok(ReducedPatch { mesh: made.mesh, attributes: made.attributes }),
        Err(SimplifyError::Interrupted) => Err(SimplifyError::Interrupted),
        // What the collapse refuses, such as coordinates at the limit of single precision, is left to the other methods.
        Err(_) => Ok(unchanged()),
    }
}

/// Drops pairs of faces over the same three vertices; `None` if no face is left.
///
/// Two groups can make such faces, as neither sees the other's. The collapse would part them, and so open the surface.
fn without_double_faces(patch: &Patch) -> Option<(TriMesh, Attributes, Vec<bool>)> {
    let (faces, sources) = distinct_faces(patch.mesh.faces().iter().copied());
    if faces.len() == patch.mesh.faces().len() {
        return Some((patch.mesh.clone(), patch.attributes.clone(), patch.locked.clone()));
    }
    let (mesh, vertices) = compact(patch.mesh.positions(), faces).ok().filter(|(mesh, _)| !mesh.faces().is_empty())?;
    let locked = vertices.iter().map(|&v| patch.locked[v as usize]).collect();
    Some((mesh, patch.attributes.clone().select_faces(&sources)?, locked))
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
