//! Vertices and triangles as they lie in the caller's buffers.

use serde::Deserialize;

use crate::message::Message;
use crate::refusal::Refusal;

/// The parts of a request that are buffers.
#[derive(Deserialize)]
pub struct Parts {
    /// The vertices of the triangles, n_faces x 3.
    indices: usize,
    /// The positions, n_vertices x 3.
    positions: usize,
    /// Numbers that belong to the vertices, n_vertices x n_weights.
    attributes: Option<usize>,
    /// Weight of each of these numbers, relative to positions in shares of the extent.
    #[serde(default)]
    weights: Vec<f32>,
    /// A byte for each vertex, whose lowest bit holds it.
    locks: Option<usize>,
    /// A group for each triangle: those of two groups have no vertex in common.
    groups: Option<usize>,
}

/// Buffers of the caller.
pub struct Buffers {
    /// The vertices of the triangles, n_faces x 3.
    pub indices: Vec<[u32; 3]>,
    /// Positions, n_vertices x 3.
    pub positions: Vec<[f32; 3]>,
    /// Attributes, n_vertices x n_weights.
    pub attributes: Vec<f32>,
    /// Weights of the attributes, n_weights.
    pub weights: Vec<f32>,
    /// Locks by the lowest bit, n_vertices or nothing.
    pub locks: Vec<u8>,
    /// The group of each triangle, n_faces or nothing.
    pub groups: Vec<u32>,
}

impl Buffers {
    /// Takes the buffers out of a message.
    ///
    /// # Errors
    /// [`Refusal`] where one is missing or of another length, an index names no vertex, or a position is not finite.
    pub fn read(message: &Message, parts: Parts) -> Result<Self, Refusal> {
        let attributes = parts.attributes.map(|part| message.numbers(part, f32::from_le_bytes)).transpose()?;
        let groups = parts.groups.map(|part| message.numbers(part, u32::from_le_bytes)).transpose()?;
        let buffers = Self {
            indices: message.rows(parts.indices, u32::from_le_bytes)?,
            positions: message.rows(parts.positions, f32::from_le_bytes)?,
            attributes: attributes.unwrap_or_default(),
            weights: parts.weights,
            locks: parts.locks.map_or(Ok(Vec::new()), |part| message.part(part).map(<[u8]>::to_vec))?,
            groups: groups.unwrap_or_default(),
        };
        buffers.check()?;
        Ok(buffers)
    }

    fn check(&self) -> Result<(), Refusal> {
        let (n, width) = (self.positions.len(), self.weights.len());
        if let Some(bad) = self.indices.as_flattened().iter().find(|&&v| v as usize >= n) {
            return Err(Refusal::new(format!("indices name vertex {bad}, and there are {n}")));
        }
        if self.positions.as_flattened().iter().any(|x| !x.is_finite()) {
            return Err(Refusal::new("positions: a number is not finite"));
        }
        if self.attributes.len() != n * width {
            return Err(Refusal::new(format!("attributes: give {width} numbers for each of {n} vertices")));
        }
        if !self.groups.is_empty() && self.groups.len() != self.indices.len() {
            return Err(Refusal::new(format!("groups: give one for each of {} triangles", self.indices.len())));
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
