//! meshoptimizer's three simplifiers, without options or error limit, down to a number of faces.
//!
//! The library's own code runs here, bound by the crate `meshopt`; nothing of it is written again.

use meshopt::{SimplifyOptions, VertexDataAdapter, simplify_sloppy, simplify_with_update, typed_to_bytes};

use super::BaselineError;
use neural_mesh::mesh::{TriMesh, compact};

/// An error that no result reaches, relative to the mesh's extent.
const NO_LIMIT: f32 = 1e10;

/// The faces that meshoptimizer's `simplify` leaves, over the vertices of the mesh: the call alone, to be timed.
///
/// It collapses edges onto one of their ends, and stops above `n_faces` where the topology holds it.
///
/// # Shapes
/// - returns at most `mesh.faces().len()` faces
///
/// ```
/// use neural_mesh_bench::baselines::meshoptimizer_faces;
/// let sphere = neural_mesh::mesh::shapes::icosphere(3);
/// assert!(meshoptimizer_faces(&sphere, 100).len() <= 100);
/// ```
pub fn meshoptimizer_faces(mesh: &TriMesh, n_faces: usize) -> Vec<[u32; 3]> {
    let Some(vertices) = vertices(mesh) else { return Vec::new() };
    let indices = mesh.faces().as_flattened();
    let left = meshopt::simplify(indices, &vertices, n_indices(mesh, n_faces), NO_LIMIT, SimplifyOptions::None, None);
    left.as_chunks().0.to_vec()
}

/// `simplify`: collapses onto vertices of the input.
pub(super) fn simplified(mesh: &TriMesh, n_faces: usize) -> Result<TriMesh, BaselineError> {
    Ok(compact(mesh.positions(), meshoptimizer_faces(mesh, n_faces))?.0)
}

/// `simplifyWithUpdate`: the vertices that stay move to where the error is least.
pub(super) fn updated(mesh: &TriMesh, n_faces: usize) -> Result<TriMesh, BaselineError> {
    let mut positions = mesh.positions().to_vec();
    let mut indices = mesh.faces().as_flattened().to_vec();
    let n_asked = n_indices(mesh, n_faces);
    let options = SimplifyOptions::None;
    let n_left =
        simplify_with_update(&mut indices, &mut positions, &mut [], &[], 0, None, n_asked, NO_LIMIT, options, None);
    Ok(compact(&positions, indices[..n_left].as_chunks().0.to_vec())?.0)
}

/// `simplifySloppy`: clusters vertices in a grid, and keeps no topology.
pub(super) fn sloppy(mesh: &TriMesh, n_faces: usize) -> Result<TriMesh, BaselineError> {
    let Some(vertices) = vertices(mesh) else { return Err(BaselineError::NothingLeft) };
    let left = simplify_sloppy(mesh.faces().as_flattened(), &vertices, n_indices(mesh, n_faces), NO_LIMIT, None);
    Ok(compact(mesh.positions(), left.as_chunks().0.to_vec())?.0)
}

/// The positions as meshoptimizer takes them, in place; none where it refuses them.
fn vertices(mesh: &TriMesh) -> Option<VertexDataAdapter<'_>> {
    VertexDataAdapter::new(typed_to_bytes(mesh.positions()), size_of::<[f32; 3]>(), 0).ok()
}

/// Indices asked for: meshoptimizer must not be asked for more than there are.
fn n_indices(mesh: &TriMesh, n_faces: usize) -> usize {
    3 * n_faces.min(mesh.faces().len())
}
