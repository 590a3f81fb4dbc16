//! Vertex and index buffers of the caller.

use super::IndexError;

/// Vertices and triangles of the caller.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Buffers {
    /// Vertices of the triangles, n_faces x 3.
    pub indices: Vec<[u32; 3]>,
    /// Positions, n_vertices x 3.
    pub positions: Vec<[f32; 3]>,
    /// Attributes, n_vertices x n_weights.
    pub attributes: Vec<f32>,
    /// Weight of each attribute, n_weights: a difference of 1 counts as a distance of this share of the extent.
    pub weights: Vec<f32>,
    /// Flags of the vertices, n_vertices or empty; the lowest bit locks a vertex.
    pub locks: Vec<u8>,
    /// Group of each triangle, n_faces or empty; triangles of different groups share no vertex.
    pub groups: Vec<u32>,
}

impl Buffers {
    /// Makes buffers of triangles without attributes.
    pub fn new(indices: Vec<[u32; 3]>, positions: Vec<[f32; 3]>) -> Self {
        Self { indices, positions, ..Self::default() }
    }

    /// Checks lengths, indices, and that all numbers are finite.
    ///
    /// # Errors
    /// [`IndexError::Buffers`] names the wrong buffer.
    pub fn check(&self) -> Result<(), IndexError> {
        let (n, width) = (self.positions.len(), self.weights.len());
        if let Some(bad) = self.indices.as_flattened().iter().find(|&&v| v as usize >= n) {
            return Err(IndexError::Buffers(format!("indices name vertex {bad}, but there are only {n} vertices")));
        }
        if self.positions.as_flattened().iter().any(|x| !x.is_finite()) {
            return Err(IndexError::Buffers("positions: a number is not finite".into()));
        }
        if self.attributes.iter().chain(&self.weights).any(|x| !x.is_finite()) {
            return Err(IndexError::Buffers("attributes: a number is not finite".into()));
        }
        if self.attributes.len() != n * width {
            return Err(IndexError::Buffers(format!("attributes: give {width} numbers for each of {n} vertices")));
        }
        if !self.locks.is_empty() && self.locks.len() != n {
            return Err(IndexError::Buffers(format!("locks: give one for each of {n} vertices")));
        }
        if !self.groups.is_empty() && self.groups.len() != self.indices.len() {
            return Err(IndexError::Buffers(format!("groups: give one for each of {} triangles", self.indices.len())));
        }
        Ok(())
    }

    /// Returns the longest side of the box around all vertices.
    pub fn extent(&self) -> f64 {
        extent(&self.positions)
    }

    /// Returns the longest side of the box around the vertices of the triangles.
    pub fn used_extent(&self) -> f64 {
        let used: Vec<[f32; 3]> = self.indices.as_flattened().iter().map(|&v| self.positions[v as usize]).collect();
        extent(&used)
    }

    pub(super) fn is_locked(&self, vertex: u32) -> bool {
        self.locks.get(vertex as usize).is_some_and(|lock| lock & 1 == 1)
    }
}

/// Returns the longest side of the box around points.
pub fn extent(positions: &[[f32; 3]]) -> f64 {
    let side = |axis: usize| {
        let coordinates = positions.iter().map(|p| f64::from(p[axis]));
        coordinates.clone().fold(f64::NEG_INFINITY, f64::max) - coordinates.fold(f64::INFINITY, f64::min)
    };
    (0..3).map(side).fold(0.0, f64::max)
}
