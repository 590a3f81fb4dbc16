//! Moves meshes to a common local origin.

use super::{Frame, InvalidMesh, TriMesh};

/// Moves all meshes to their first local origin that is not zero.
///
/// # Errors
/// [`InvalidMesh`] if single precision cannot hold a mesh about that origin.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::mesh::{Frame, move_to_common_frame, shapes};
/// let far = |x: f64| (shapes::tetrahedron(), Frame { origin: [x, 0.0, 0.0], double: true });
/// let meshes = move_to_common_frame(vec![far(4_194_304.0), far(4_194_304.25)]).unwrap();
/// assert_eq!(meshes[1].positions()[0][0] - meshes[0].positions()[0][0], 0.25);
/// ```
pub fn move_to_common_frame(meshes: Vec<(TriMesh, Frame)>) -> Result<Vec<TriMesh>, InvalidMesh> {
    let origin = meshes.iter().map(|(_, frame)| frame.origin).find(|origin| *origin != [0.0; 3]).unwrap_or_default();
    meshes.into_iter().map(|(mesh, frame)| move_to_origin(origin, mesh, frame)).collect()
}

fn move_to_origin(origin: [f64; 3], mesh: TriMesh, frame: Frame) -> Result<TriMesh, InvalidMesh> {
    if frame.origin == origin {
        return Ok(mesh);
    }
    let (mut positions, faces) = mesh.into_parts();
    for position in &mut positions {
        for axis in 0..3 {
            position[axis] = (frame.origin[axis] - origin[axis] + f64::from(position[axis])) as f32;
        }
    }
    TriMesh::new(positions, faces)
}
