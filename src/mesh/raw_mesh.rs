//! A mesh as a file states it: parsed, not yet checked.

use super::Attributes;

/// Vertices and triangles as read: indices may be out of range, coordinates may be NaN, positions may repeat.
///
/// Polygons are triangulated by the reader; everything else that can be wrong is `cleanup`'s to handle.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
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

impl RawMesh {
    /// Vertices and triangles alone.
    pub fn new(positions: Vec<[f64; 3]>, faces: Vec<[u32; 3]>) -> Self {
        Self { positions, faces, ..Self::default() }
    }

    /// The diagonal of the box around all vertices whose coordinates are finite; 0 where there is none.
    pub fn diagonal(&self) -> f64 {
        let finite = self.positions.iter().filter(|position| position.iter().all(|x| x.is_finite()));
        let unbounded = (glam::DVec3::INFINITY, glam::DVec3::NEG_INFINITY);
        let (low, high) =
            finite.fold(unbounded, |(low, high), &position| (low.min(position.into()), high.max(position.into())));
        (high - low).max(glam::DVec3::ZERO).length()
    }
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
    /// The local coordinates of a position of the file, without negative zeros.
    pub fn to_local(&self, position: [f64; 3]) -> [f32; 3] {
        std::array::from_fn(|axis| (position[axis] - self.origin[axis]) as f32 + 0.0)
    }

    /// The coordinates that a writer puts down for a local position, rounded as the file rounds them.
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
