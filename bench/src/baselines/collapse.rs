//! The collapse of plain meshes, on one thread.

use neural_mesh::mesh::{TriMesh, compact};
use neural_mesh_collapse::{CollapseOptions, CollapseSize, collapse};

use super::BaselineError;

pub(super) fn simplify(mesh: &TriMesh, n_faces: usize, n_fit_steps: usize) -> Result<TriMesh, BaselineError> {
    let mut options = CollapseOptions::default();
    options.n_fit_steps = n_fit_steps;
    // A `TriMesh` is valid, so only one too large for 32 bits is refused.
    let result = collapse(mesh.positions(), mesh.faces(), CollapseSize::Faces(n_faces), &options);
    let result = result.map_err(|_| BaselineError::NothingLeft)?;
    Ok(compact(&result.positions, result.faces)?.0)
}
