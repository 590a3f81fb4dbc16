//! meshoptimizer's two simplifiers, without options or error limit.

use meshopt::{SimplifyOptions, VertexDataAdapter, simplify_with_update, typed_to_bytes};

use anyhow::Result;
use neural_mesh::mesh::{TriMesh, compact};

// Error bound that no result reaches, so that only the number of faces counts.
const NO_LIMIT: f32 = 1e10;

/// Returns the faces of meshoptimizer's `simplify`, which may stop above `n_faces`.
pub fn meshoptimizer_faces(mesh: &TriMesh, n_faces: usize) -> Vec<[u32; 3]> {
    let positions = typed_to_bytes(mesh.positions());
    let Ok(vertices) = VertexDataAdapter::new(positions, size_of::<[f32; 3]>(), 0) else { return Vec::new() };
    let indices = mesh.faces().as_flattened();
    let left = meshopt::simplify(indices, &vertices, n_indices(mesh, n_faces), NO_LIMIT, SimplifyOptions::None, None);
    left.as_chunks().0.to_vec()
}

pub(super) fn simplify(mesh: &TriMesh, n_faces: usize) -> Result<TriMesh> {
    Ok(compact(mesh.positions(), meshoptimizer_faces(mesh, n_faces))?.0)
}

pub(super) fn simplify_updating(mesh: &TriMesh, n_faces: usize) -> Result<TriMesh> {
    let mut positions = mesh.positions().to_vec();
    let mut indices = mesh.faces().as_flattened().to_vec();
    let n_target = n_indices(mesh, n_faces);
    let options = SimplifyOptions::None;
    let n_left =
        simplify_with_update(&mut indices, &mut positions, &mut [], &[], 0, None, n_target, NO_LIMIT, options, None);
    Ok(compact(&positions, indices[..n_left].as_chunks().0.to_vec())?.0)
}

fn n_indices(mesh: &TriMesh, n_faces: usize) -> usize {
    3 * n_faces.min(mesh.faces().len())
}
