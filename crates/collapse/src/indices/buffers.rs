//! Vertex and index buffers of the caller, before and after.

use crate::collapse::{CollapseError, bounding_box};

/// Triangles of the caller, with what holds and weighs.
#[derive(Clone, Copy, Debug, Default)]
pub struct IndexBuffers<'a> {
    /// Vertices of the triangles, n_faces x 3.
    pub indices: &'a [[u32; 3]],
    /// Positions, n_vertices x 3, in any unit.
    pub positions: &'a [[f32; 3]],
    /// Attributes, n_vertices x n_weights.
    pub attributes: &'a [f32],
    /// Weight of each attribute: a difference of 1 counts as a distance of this share of the extent. One of 0 is carried.
    pub weights: &'a [f32],
    /// Group of each triangle, such as its material; n_faces, or empty. Between groups the course of edges is kept.
    pub groups: &'a [u32],
    /// True for a vertex that stays, with all others at its position; n_vertices, or empty.
    pub locks: &'a [bool],
}

/// Simplified index buffers.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct IndexResult {
    /// Vertices of the caller at the corners of the faces, n_faces x 3.
    pub indices: Vec<[u32; 3]>,
    /// For each face the one of the input that it was, n_faces.
    pub sources: Vec<u32>,
    /// The estimated error, in the unit of [`IndexOptions::max_error`](crate::IndexOptions::max_error).
    pub error: f32,
    /// Vertices that have moved, and their new positions.
    pub moved: Vec<(u32, [f32; 3])>,
    /// The attributes of the vertices in `moved`, n_moved x n_weights.
    pub attributes: Vec<f32>,
}

impl IndexResult {
    /// Writes vertices that have moved, and their attributes, over those of the caller.
    pub fn write_moved(&self, positions: &mut [[f32; 3]], attributes: &mut [f32]) {
        let width = self.attributes.len() / self.moved.len().max(1);
        for (i, &(v, position)) in self.moved.iter().enumerate() {
            positions[v as usize] = position;
            attributes[v as usize * width..][..width].copy_from_slice(&self.attributes[i * width..][..width]);
        }
    }
}

/// Returns the longest side of the box around points.
pub fn measure_extent(positions: &[[f32; 3]]) -> f32 {
    let [low, high] = bounding_box(positions);
    (0..3).map(|k| high[k] - low[k]).fold(0.0, f32::max)
}

impl IndexBuffers<'_> {
    pub(super) fn check(&self) -> Result<(), CollapseError> {
        let n = self.positions.len();
        if let Some(face) = self.indices.iter().position(|face| face.iter().any(|&v| v as usize >= n)) {
            return Err(CollapseError::IndexOutOfRange { face });
        }
        if let Some(vertex) = self.positions.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
            return Err(CollapseError::NotFinite { vertex });
        }
        if self.attributes.len() != n * self.weights.len() {
            return Err(CollapseError::WrongLength { what: "attributes" });
        }
        if let Some(i) = self.attributes.iter().position(|x| !x.is_finite()) {
            return Err(CollapseError::NotFinite { vertex: i / self.weights.len().max(1) });
        }
        if !self.groups.is_empty() && self.groups.len() != self.indices.len() {
            return Err(CollapseError::WrongLength { what: "groups" });
        }
        if !self.locks.is_empty() && self.locks.len() != n {
            return Err(CollapseError::WrongLength { what: "locks" });
        }
        Ok(())
    }

    /// Returns the values of all vertices in the order of the collapse, their columns, and how many have weights.
    ///
    /// Those with weights come first, in units of the extent; the others are there only if vertices move.
    pub(super) fn sort_attributes(&self, moves: bool) -> (Vec<f32>, Vec<usize>, usize) {
        let (mut columns, others): (Vec<usize>, Vec<usize>) =
            (0..self.weights.len()).partition(|&k| self.weights[k] > 0.0);
        let n_counted = columns.len();
        columns.extend(others.into_iter().filter(|_| moves));
        let rows = self.attributes.chunks(self.weights.len().max(1));
        let values = rows.flat_map(|row| columns.iter().map(|&k| row[k] * self.scale(k))).collect();
        (values, columns, n_counted)
    }

    pub(super) fn scale(&self, attribute: usize) -> f32 {
        if self.weights[attribute] > 0.0 { self.weights[attribute] } else { 1.0 }
    }
}
