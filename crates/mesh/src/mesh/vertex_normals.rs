//! Vertex normals from the surrounding faces.

use glam::Vec3;

use super::TriMesh;
use crate::geometry::triangle::area_normal;

/// Returns area-weighted unit normals at the vertices, n_vertices x 3, or zero.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::mesh::{TriMesh, vertex_normals};
/// let mesh = TriMesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]).unwrap();
/// assert_eq!(vertex_normals(&mesh), [[0.0, 0.0, 1.0]; 3]);
/// ```
pub fn vertex_normals(mesh: &TriMesh) -> Vec<[f32; 3]> {
    let sums = sum_face_normals(mesh.positions(), mesh.faces());
    sums.into_iter().map(|sum| sum.normalize_or_zero().to_array()).collect()
}

/// Returns the sum of the area normals around each vertex.
#[doc(hidden)]
pub fn sum_face_normals(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> Vec<Vec3> {
    let mut sums = vec![Vec3::ZERO; positions.len()];
    for face in faces {
        let normal = area_normal(face.map(|v| Vec3::from(positions[v as usize])));
        face.iter().for_each(|&v| sums[v as usize] += normal);
    }
    sums
}
