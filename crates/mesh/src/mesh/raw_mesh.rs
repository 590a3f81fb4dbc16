//! A mesh as read from a file.

use super::Attributes;
use crate::geometry::extent;

/// Vertices and triangles as read; indices may be out of range, coordinates NaN, positions repeated.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RawMesh {
    /// Positions in the file's frame, n_vertices x 3.
    pub positions: Vec<[f64; 3]>,
    /// Vertex indices, n_faces x 3.
    pub faces: Vec<[u32; 3]>,
    /// True if the file stored more precision than `f32`.
    pub double: bool,
    /// Number of the file's faces with fewer than three corners.
    pub dropped_faces: usize,
    /// Attributes; their wedges and groups have one row per face.
    pub attributes: Attributes,
}

impl RawMesh {
    /// Makes a mesh without attributes.
    pub fn new(positions: Vec<[f64; 3]>, faces: Vec<[u32; 3]>) -> Self {
        Self { positions, faces, ..Self::default() }
    }

    /// Returns the diagonal of the bounding box of all finite vertices.
    pub fn diagonal(&self) -> f64 {
        let finite = self.positions.iter().filter(|position| position.iter().all(|x| x.is_finite()));
        let (low, high) = extent(finite.map(|&position| position.into()));
        (high - low).max(glam::DVec3::ZERO).length()
    }
}

/// The relation of `f32` coordinates to the file's: `file = origin + local`.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// let frame = neural_mesh::mesh::Frame { origin: [5e6, 0.0, 0.0], double: true };
/// assert_eq!(frame.to_file([0.25, 1.0, 2.0]), [5000000.25, 1.0, 2.0]);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Frame {
    /// Local origin in the file's coordinates.
    pub origin: [f64; 3],
    /// True if the file holds doubles; otherwise written coordinates are rounded to `f32`.
    pub double: bool,
}

impl Frame {
    /// Converts a position of the file to local coordinates.
    pub fn to_local(&self, position: [f64; 3]) -> [f32; 3] {
        std::array::from_fn(|axis| (position[axis] - self.origin[axis]) as f32 + 0.0)
    }

    /// Converts a local position to the file's coordinates, rounded as stored.
    pub fn to_file(&self, local: [f32; 3]) -> [f64; 3] {
        std::array::from_fn(|axis| {
            let exact = self.origin[axis] + f64::from(local[axis]);
            if self.double { exact } else { f64::from(exact as f32) }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::RawMesh;

    #[test]
    fn the_diagonal_is_that_of_the_finite_vertices() {
        let positions = vec![[1.0, 2.0, 3.0], [f64::NAN, 0.0, 0.0], [4.0, 6.0, 3.0], [0.0, f64::INFINITY, 0.0]];
        assert_eq!(RawMesh { positions, ..RawMesh::default() }.diagonal(), 5.0);
        assert_eq!(RawMesh::default().diagonal(), 0.0);
    }
}
