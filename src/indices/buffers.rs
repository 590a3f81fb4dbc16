//! Vertices and triangles as they lie in the caller's buffers.

use super::IndexError;

/// Buffers of the caller.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Buffers {
    /// The vertices of the triangles, n_faces x 3.
    pub indices: Vec<[u32; 3]>,
    /// Positions, n_vertices x 3.
    pub positions: Vec<[f32; 3]>,
    /// Attributes, n_vertices x n_weights.
    pub attributes: Vec<f32>,
    /// Weight of each attribute, n_weights, relative to positions in shares of the extent.
    pub weights: Vec<f32>,
    /// Locks by the lowest bit, n_vertices or nothing.
    pub locks: Vec<u8>,
    /// The group of each triangle, n_faces or nothing; those of two groups have no vertex in common.
    pub groups: Vec<u32>,
}

impl Buffers {
    /// Triangles over positions alone.
    pub fn new(indices: Vec<[u32; 3]>, positions: Vec<[f32; 3]>) -> Self {
        Self { indices, positions, ..Self::default() }
    }

    /// Refuses buffers of wrong lengths, indices of no vertex, and numbers that are not finite.
    ///
    /// # Errors
    /// [`IndexError::Buffers`] says which.
    pub fn check(&self) -> Result<(), IndexError> {
        let (n, width) = (self.positions.len(), self.weights.len());
        if let Some(bad) = self.indices.as_flattened().iter().find(|&&v| v as usize >= n) {
            return Err(IndexError::Buffers(format!("indices name vertex {bad}, and there are {n}")));
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

    /// The longest side of the box around the vertices.
    pub fn extent(&self) -> f64 {
        extent(&self.positions)
    }
}

/// The longest side of the box around points.
pub fn extent(positions: &[[f32; 3]]) -> f64 {
    let side = |axis: usize| {
        let along = positions.iter().map(|p| f64::from(p[axis]));
        along.clone().fold(f64::NEG_INFINITY, f64::max) - along.fold(f64::INFINITY, f64::min)
    };
    (0..3).map(side).fold(0.0, f64::max)
}
