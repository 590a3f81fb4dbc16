//! Index buffers over vertices that stay where they are in their buffers: what meshoptimizer's `MeshoptSimplifier` is asked.

mod buffers;
mod distance;
mod places;
mod points;
mod welded;

use std::ops::ControlFlow;

use neural_mesh::search::simplify_to_error;
use neural_mesh::simplify::{Listener, Options, Purpose, Simplified, SimplifyError, Target, simplify_input};
use serde::Deserialize;
use serde_json::{Value, json};

use crate::answer::Tell;
use crate::message::{Answer, Message};
use crate::refusal::Refusal;
use buffers::{Buffers, Parts};
use distance::measure_distance;
use welded::WeldedMesh;

pub use points::select_points;

/// Sizes that are tried to find the smallest within a distance in numbers of vertices.
const TRIES: usize = 8;

/// A request for lighter indices.
#[derive(Deserialize)]
struct IndexRequest {
    #[serde(flatten)]
    parts: Parts,
    /// Indices that may be left, three for each face.
    target: usize,
    /// Largest distance from the original, as a share of its extent or in its unit.
    error: f64,
    /// Whether vertices move.
    #[serde(default, rename = "move")]
    moves: bool,
    /// Names of flags.
    #[serde(default)]
    flags: Vec<String>,
}

/// Answers with the indices that are left and how far they are from the original.
///
/// # Errors
/// [`Refusal`] where buffers are wrong or whoever is told ends the run.
pub fn simplify_indices(message: &Message, json: Value, answer: &mut Answer, mut tell: Tell) -> Result<Value, Refusal> {
    let asked: IndexRequest = serde_json::from_value(json)?;
    let has = |flag: &str| asked.flags.iter().any(|name| name == flag);
    let mut options = Options::new(Target::Faces((asked.target / 3).max(1)));
    (options.subset, options.map) = (!asked.moves, asked.moves);
    (options.lock_boundaries, options.prune) = (has("LockBorder"), has("Prune"));
    let unit = |buffers: &Buffers| if has("ErrorAbsolute") { 1.0 } else { buffers.extent().max(f64::MIN_POSITIVE) };
    let mut buffers = Buffers::read(message, asked.parts)?;
    let given = WeldedMesh::new(&buffers)?;
    if given.mesh.faces().is_empty() {
        let none = answer.add(Vec::new());
        return Ok(json!({ "indices": none, "groups": none, "error": 0.0, "positions": none, "attributes": none }));
    }
    if buffers.weights.iter().any(|weight| *weight > 0.0) {
        options.purpose = Purpose::Poses;
    }
    let most = asked.error * unit(&buffers);
    let (made, error) = simplify_within(&given, options, most, &mut |event| tell(f64::from(event.total), 0))?;
    let wedges = if asked.moves { given.place_vertices(&made, &mut buffers) } else { given.corner_vertices(&made) };
    let mut json = json!({
        "indices": answer.add_numbers(wedges.into_iter().flatten(), u32::to_le_bytes),
        "groups": answer.add_numbers(made.attributes.groups, u32::to_le_bytes),
        "error": error / unit(&buffers),
    });
    if asked.moves {
        json["positions"] = answer.add_numbers(buffers.positions.into_flattened(), f32::to_le_bytes).into();
        json["attributes"] = answer.add_numbers(buffers.attributes, f32::to_le_bytes).into();
    }
    Ok(json)
}

/// Simplifies to the size, or to a larger one that holds the distance; returns the distance, too.
fn simplify_within(
    given: &WeldedMesh,
    options: Options,
    most: f64,
    listener: &mut Listener,
) -> Result<(Simplified, f64), Refusal> {
    let input = given.to_input();
    let at = |target: Target, listener: &mut Listener| -> Result<(Simplified, f64), Refusal> {
        let mut options = options.clone();
        options.target = target;
        let made = simplify_input(&input, None, &options, listener)?;
        let distance = measure_distance(given, &made);
        Ok((made, distance))
    };
    let small = at(options.target, listener)?;
    if small.1 <= most {
        return Ok(small);
    }
    let n_small = small.0.mesh.faces().len();
    if options.purpose != Purpose::Poses {
        let near = simplify_to_error(&input, None, &options, most, listener)?.simplified;
        let distance = measure_distance(given, &near);
        return Ok((near, distance));
    }
    let (mut low, mut best) = (n_small, at(Target::Ratio(1.0), listener)?);
    for _ in 0..TRIES {
        let high = best.0.mesh.faces().len();
        let middle = ((low as f64) * (high as f64)).sqrt() as usize;
        if middle <= low || middle >= high {
            break;
        }
        let made = at(Target::Faces(middle), listener)?;
        if made.1 <= most && made.0.mesh.faces().len() < high { best = made } else { low = middle }
    }
    Ok(best)
}

/// A request to drop small components.
#[derive(Deserialize)]
struct PruneRequest {
    #[serde(flatten)]
    parts: Parts,
    /// Largest radius of what is dropped, as a share of the extent.
    error: f64,
}

/// Answers with the indices of the components that are large enough.
///
/// # Errors
/// [`Refusal`] where buffers are wrong.
pub fn prune_components(message: &Message, json: Value, answer: &mut Answer) -> Result<Value, Refusal> {
    let PruneRequest { parts, error } = serde_json::from_value(json)?;
    let buffers = Buffers::read(message, parts)?;
    let given = WeldedMesh::new(&buffers)?;
    let mut options = Options::new(Target::Ratio(1.0));
    (options.prune_below, options.prune, options.subset) = (2.0 * error * buffers.extent(), false, true);
    let wedges = match simplify_input(&given.to_input(), None, &options, &mut |_| ControlFlow::Continue(())) {
        Err(SimplifyError::Empty) => Vec::new(),
        made => given.corner_vertices(&made?),
    };
    let indices = answer.add_numbers(wedges.into_flattened(), u32::to_le_bytes);
    Ok(json!({ "indices": indices }))
}
