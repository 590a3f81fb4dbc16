//! Fewer triangles over the vertices that a mesh has.

use bevy_mesh::{Indices, Mesh};
use neural_mesh_collapse::{IndexBuffers, IndexOptions};

use crate::MeshError;
use crate::mesh_source::read_triangles;
use crate::result_mesh::MAX_SHORT;

/// Returns the indices of at most `n_faces` triangles over the mesh's own vertices, and their error.
///
/// For meshes that are made while a game runs: several times as fast as [`simplify_mesh`](crate::simplify_mesh), farther
/// from the original. No vertex moves, so that attributes of any format stay as they are, and only positions are read.
/// Sides of a seam stay apart. The error is an estimate of the largest distance, as a share of the longest side of the
/// bounding box; merges above `max_error` are not made, and 1 or more is no bound. A mesh without indices keeps all
/// triangles, as no two of them share a vertex.
///
/// # Errors
/// [`MeshError`] for a mesh that is no list of triangles, or has a coordinate that is not finite.
///
/// ```
/// use bevy_mesh::{Indices, Mesh, PrimitiveTopology};
/// use neural_mesh_bevy::simplify_indices;
/// # let (positions, faces) = neural_mesh::mesh::shapes::icosphere(3).into_parts();
/// # let mut sphere = Mesh::new(PrimitiveTopology::TriangleList, Default::default())
/// #     .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
/// #     .with_inserted_indices(Indices::U32(faces.into_flattened()));
/// let (indices, error) = simplify_indices(&sphere, 200, 1.0)?;
/// sphere.insert_indices(indices);
/// assert!(sphere.indices().map(Indices::len) == Some(600) && error < 0.1);
/// # Ok::<(), neural_mesh_bevy::MeshError>(())
/// ```
pub fn simplify_indices(mesh: &Mesh, n_faces: usize, max_error: f32) -> Result<(Indices, f32), MeshError> {
    let (positions, indices) = read_triangles(mesh)?;
    let buffers = IndexBuffers { indices: &indices, positions, ..IndexBuffers::default() };
    let mut options = IndexOptions::new(n_faces, max_error);
    options.n_threads = 0;
    let result = neural_mesh_collapse::simplify_indices(&buffers, &options)?;
    let chosen = result.indices.into_flattened();
    let is_short = !matches!(mesh.indices(), Some(Indices::U32(_))) && positions.len() <= MAX_SHORT;
    let indices = match is_short {
        true => Indices::U16(chosen.into_iter().map(|index| index as u16).collect()),
        false => Indices::U32(chosen),
    };
    Ok((indices, result.error))
}
