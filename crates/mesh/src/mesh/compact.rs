//! Submeshes without unused vertices.

use super::{InvalidMesh, TriMesh};

/// Builds a mesh from `faces` and only the vertices they use; also returns the old index of each vertex.
///
/// # Errors
/// [`InvalidMesh`] as for [`TriMesh::new`].
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::mesh::compact;
/// let positions = [[0.0; 3], [9.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let (mesh, sources) = compact(&positions, vec![[0, 2, 3]]).unwrap();
/// assert_eq!((mesh.faces(), &sources[..]), (&[[0, 1, 2]][..], &[0, 2, 3][..]));
/// ```
pub fn compact(positions: &[[f32; 3]], mut faces: Vec<[u32; 3]>) -> Result<(TriMesh, Vec<u32>), InvalidMesh> {
    if let Some(face) = faces.iter().position(|face| face.iter().any(|&v| v as usize >= positions.len())) {
        return Err(InvalidMesh::OutOfRange { face });
    }
    let used = used_vertices(&faces, positions.len());
    let sources = renumber_used(&mut faces, &used);
    let positions = sources.iter().map(|&v| positions[v as usize]).collect();
    TriMesh::new(positions, faces).map(|mesh| (mesh, sources))
}

pub(super) fn used_vertices(faces: &[[u32; 3]], n_vertices: usize) -> Vec<bool> {
    let mut used = vec![false; n_vertices];
    faces.as_flattened().iter().for_each(|&v| used[v as usize] = true);
    used
}

/// Numbers the used vertices without gaps; returns the old index of each.
pub(super) fn renumber_used(faces: &mut [[u32; 3]], used: &[bool]) -> Vec<u32> {
    let sources: Vec<u32> = (0..used.len() as u32).filter(|&v| used[v as usize]).collect();
    let mut number = vec![0; used.len()];
    sources.iter().enumerate().for_each(|(new, &old)| number[old as usize] = new as u32);
    faces.as_flattened_mut().iter_mut().for_each(|v| *v = number[*v as usize]);
    sources
}
