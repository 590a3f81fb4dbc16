//! A mesh as a file states it: parsed, not yet checked.

use super::Attributes;

/// Vertices and triangles as read: indices may be out of range, coordinates may be NaN, positions may repeat.
///
/// Polygons are triangulated by the reader; everything else that can be wrong is `cleanup`'s to handle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RawMesh {
    /// Positions, n_vertices x 3, in the file's units and frame.
    pub positions: Vec<[f64; 3]>,
    /// Vertex indices of the triangles, n_faces x 3.
    pub faces: Vec<[u32; 3]>,
    /// Whether the file stored more precision than `f32` holds; then results are written in double too.
    pub double: bool,
    /// Faces of the file that could not become triangles (fewer than three corners).
    pub dropped_faces: usize,
    /// What corners and faces carry, with a row for each of `faces` where there is anything.
    pub attributes: Attributes,
}

/// How the `f32` coordinates of a [`TriMesh`](super::TriMesh) lie in the file: `file = origin + local`.
///
/// ```
/// let frame = neural_mesh::mesh::Frame { origin: [5e6, 0.0, 0.0], double: true };
/// assert_eq!(frame.to_file([0.25, 1.0, 2.0]), [5000000.25, 1.0, 2.0]);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Frame {
    /// Where the local origin lies, in the file's coordinates.
    pub origin: [f64; 3],
    /// Whether the file holds doubles; otherwise coordinates are rounded to `f32` when written.
    pub double: bool,
}

impl Frame {
    /// The coordinates that a writer puts down for a local position, rounded as the file rounds them.
    pub fn to_file(&self, local: [f32; 3]) -> [f64; 3] {
        std::array::from_fn(|axis| {
            let exact = self.origin[axis] + f64::from(local[axis]);
            if self.double { exact } else { f64::from(exact as f32) }
        })
    }
}
