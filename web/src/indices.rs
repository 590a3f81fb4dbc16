//! Requests for index buffers and points, as of meshoptimizer's `MeshoptSimplifier`.

use neural_mesh_collapse::{
    IndexBuffers, IndexOptions, prune_components, select_points, simplify_indices, simplify_sloppily,
};
use serde_json::{Value, json};

use crate::message::{Answer, Message};
use crate::refusal::Refusal;

/// A request; the JSON names its parts by number.
///
/// - `indices`: the triangles' vertices, n_faces x 3; `positions`: n_vertices x 3
/// - `attributes`: n_vertices x n_weights, with `weights` in the JSON; `groups`: one per triangle; `locks`: a byte per vertex
/// - `target`: number of indices, three per face, or of points; `error`: largest estimated error
struct IndexRequest {
    json: Value,
    indices: Vec<[u32; 3]>,
    positions: Vec<[f32; 3]>,
    attributes: Vec<f32>,
    weights: Vec<f32>,
    groups: Vec<u32>,
    locks: Vec<bool>,
}

impl IndexRequest {
    fn read(json: Value, message: &Message) -> Result<IndexRequest, Refusal> {
        // A part that is missing is empty: part 0 is the JSON.
        let part = |name: &str| json[name].as_u64().unwrap_or_default() as usize;
        Ok(IndexRequest {
            indices: if part("indices") > 0 { message.rows(part("indices"), u32::from_le_bytes)? } else { Vec::new() },
            positions: message.rows(part("positions"), f32::from_le_bytes)?,
            attributes: read_numbers(message, part("attributes"), f32::from_le_bytes)?,
            weights: json["weights"].as_array().into_iter().flatten().map(to_number).collect(),
            groups: read_numbers(message, part("groups"), u32::from_le_bytes)?,
            locks: read_numbers(message, part("locks"), |[lock]| lock & 1 == 1)?,
            json,
        })
    }

    fn to_buffers(&self) -> IndexBuffers<'_> {
        let IndexRequest { indices, positions, attributes, weights, groups, locks, .. } = self;
        IndexBuffers { indices, positions, attributes, weights, groups, locks }
    }

    fn target(&self) -> usize {
        self.json["target"].as_u64().unwrap_or_default() as usize
    }

    fn error(&self) -> f32 {
        to_number(&self.json["error"])
    }

    fn has(&self, flag: &str) -> bool {
        self.json["flags"].as_array().is_some_and(|flags| flags.iter().any(|name| name == flag))
    }

    fn moves(&self) -> bool {
        self.json["move"] == true
    }
}

fn read_numbers<T, const N: usize>(message: &Message, part: usize, of: fn([u8; N]) -> T) -> Result<Vec<T>, Refusal> {
    if part == 0 { Ok(Vec::new()) } else { message.numbers(part, of) }
}

fn to_number(json: &Value) -> f32 {
    json.as_f64().unwrap_or_default() as f32
}

/// Answers one of the calls `indices`, `sloppy`, `prune` and `points`.
///
/// # Errors
/// [`Refusal`] if the call is another or buffers are wrong.
pub fn answer_call(call: &str, message: &Message, json: Value, answer: &mut Answer) -> Result<Value, Refusal> {
    let request = IndexRequest::read(json, message)?;
    let buffers = request.to_buffers();
    match call {
        "indices" => simplify(&request, answer),
        "sloppy" => {
            let (indices, error) = simplify_sloppily(&buffers, request.target() / 3, request.error())?;
            Ok(json!({ "indices": add_faces(indices, answer), "error": error }))
        }
        "prune" => Ok(json!({ "indices": add_faces(prune_components(&buffers, request.error())?, answer) })),
        _ => {
            // Attributes of points are their colours, of one weight.
            let (colors, _) = request.attributes.as_chunks();
            let weight = request.weights.first().copied().unwrap_or_default();
            let chosen = select_points(&request.positions, colors, weight, request.target())?;
            Ok(json!({ "indices": answer.add_numbers(chosen, u32::to_le_bytes) }))
        }
    }
}

fn simplify(request: &IndexRequest, answer: &mut Answer) -> Result<Value, Refusal> {
    let mut options = IndexOptions::new(request.target() / 3, request.error());
    options.moves = request.moves();
    (options.is_absolute, options.is_sparse) = (request.has("ErrorAbsolute"), request.has("Sparse"));
    (options.locks_boundaries, options.prunes) = (request.has("LockBorder"), request.has("Prune"));
    let result = simplify_indices(&request.to_buffers(), &options)?;
    let (mut positions, mut attributes) = (Vec::new(), Vec::new());
    if options.moves {
        (positions, attributes) = (request.positions.clone(), request.attributes.clone());
        result.write_moved(&mut positions, &mut attributes);
    }
    let groups: Vec<u32> =
        result.sources.iter().filter_map(|&face| request.groups.get(face as usize).copied()).collect();
    let mut json = json!({
        "indices": add_faces(result.indices, answer),
        "groups": answer.add_numbers(groups, u32::to_le_bytes),
        "error": result.error,
    });
    if options.moves {
        json["positions"] = answer.add_numbers(positions.into_flattened(), f32::to_le_bytes).into();
        json["attributes"] = answer.add_numbers(attributes, f32::to_le_bytes).into();
    }
    Ok(json)
}

fn add_faces(faces: Vec<[u32; 3]>, answer: &mut Answer) -> usize {
    answer.add_numbers(faces.into_flattened(), u32::to_le_bytes)
}
