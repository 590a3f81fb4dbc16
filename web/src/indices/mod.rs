//! Requests for index buffers, as of meshoptimizer's `MeshoptSimplifier`.

mod points;

use neural_mesh::indices::{self, Buffers, IndexError, IndexOptions, Indices};
use serde::Deserialize;
use serde_json::{Value, json};

use crate::message::{Answer, Message, ProgressListener};
use crate::refusal::Refusal;

pub use points::select_points;

#[derive(Deserialize)]
struct BufferParts {
    /// Part with the triangles' vertices, n_faces x 3.
    indices: usize,
    /// Part with the positions, n_vertices x 3.
    positions: usize,
    /// Part with the attributes, n_vertices x n_weights.
    attributes: Option<usize>,
    /// Weights of the attributes; a difference of 1 counts as a distance of the weight times the extent.
    #[serde(default)]
    weights: Vec<f32>,
    /// Part with a byte per vertex; an odd value locks the vertex.
    locks: Option<usize>,
    /// Part with the group of each triangle; triangles of two groups share no vertex.
    groups: Option<usize>,
}

impl BufferParts {
    fn read(self, message: &Message) -> Result<Buffers, Refusal> {
        let attributes = self.attributes.map(|part| message.numbers(part, f32::from_le_bytes)).transpose()?;
        let groups = self.groups.map(|part| message.numbers(part, u32::from_le_bytes)).transpose()?;
        let indices = message.rows(self.indices, u32::from_le_bytes)?;
        let mut buffers = Buffers::new(indices, message.rows(self.positions, f32::from_le_bytes)?);
        (buffers.attributes, buffers.weights) = (attributes.unwrap_or_default(), self.weights);
        buffers.locks = self.locks.map_or(Ok(Vec::new()), |part| message.part(part).map(<[u8]>::to_vec))?;
        buffers.groups = groups.unwrap_or_default();
        Ok(buffers)
    }
}

#[derive(Deserialize)]
struct IndexRequest {
    #[serde(flatten)]
    parts: BufferParts,
    /// Requested number of indices, three per face.
    target: usize,
    /// Largest distance to the original, as a share of the extent or in the unit of the positions.
    error: f64,
    #[serde(default, rename = "move")]
    moves: bool,
    #[serde(default)]
    flags: Vec<String>,
}

/// Answers with the remaining indices and their distance to the original.
///
/// # Errors
/// [`Refusal`] if buffers are wrong or the listener ends the run.
pub fn simplify_indices(
    message: &Message,
    json: Value,
    answer: &mut Answer,
    mut listener: ProgressListener,
) -> Result<Value, Refusal> {
    let request_json: IndexRequest = serde_json::from_value(json)?;
    let has = |flag: &str| request_json.flags.iter().any(|name| name == flag);
    let mut options = IndexOptions::new(request_json.target / 3, request_json.error);
    (options.is_absolute, options.moves) = (has("ErrorAbsolute"), request_json.moves);
    (options.lock_borders, options.prune, options.is_sparse) = (has("LockBorder"), has("Prune"), has("Sparse"));
    let buffers = request_json.parts.read(message)?;
    let result = indices::simplify_indices(buffers, &options, &mut |event| listener(f64::from(event.total), 0))?;
    let Indices { indices, groups, error, buffers, .. } = result;
    let mut json = json!({
        "indices": answer.add_numbers(indices.into_flattened(), u32::to_le_bytes),
        "groups": answer.add_numbers(groups, u32::to_le_bytes),
        "error": error,
    });
    if request_json.moves {
        json["positions"] = answer.add_numbers(buffers.positions.into_flattened(), f32::to_le_bytes).into();
        json["attributes"] = answer.add_numbers(buffers.attributes, f32::to_le_bytes).into();
    }
    Ok(json)
}

impl From<IndexError> for Refusal {
    fn from(error: IndexError) -> Self {
        match error {
            IndexError::Simplify(error) => error.into(),
            other => Self::new(other),
        }
    }
}

#[derive(Deserialize)]
struct PruneRequest {
    #[serde(flatten)]
    parts: BufferParts,
    /// Largest radius of dropped components, as a share of the extent.
    error: f64,
}

/// Answers with the indices of the components that are large enough.
///
/// # Errors
/// [`Refusal`] if buffers are wrong.
pub fn prune_components(message: &Message, json: Value, answer: &mut Answer) -> Result<Value, Refusal> {
    let PruneRequest { parts, error } = serde_json::from_value(json)?;
    let indices = indices::prune_components(&parts.read(message)?, error)?;
    Ok(json!({ "indices": answer.add_numbers(indices.into_flattened(), u32::to_le_bytes) }))
}
