//! Patches of a cloud, predicted by the networks.

use super::{KEPT, Neighbourhoods, Patch, PatchFrame, forward};
use neural_mesh::autodiff::{Tape, Tensors, Value};
use neural_mesh::linalg::Matrix;
use neural_mesh::parallel;
use std::sync::Arc;

const BATCH: usize = 64;

/// Returns the predicted patch of each point: itself and at most [`KEPT`] others.
///
/// # Shapes
/// - `points`: n x 3, finite
///
/// # Panics
/// If tensors are missing or have wrong shapes.
pub fn learned_patches(points: &[[f32; 3]], tensors: &Tensors<Arc<Matrix>>) -> Vec<Patch> {
    let tensors = tensors.constants();
    let around = Neighbourhoods::new(points);
    let centres: Vec<u32> = (0..points.len() as u32).collect();
    parallel::chunks(&centres, BATCH, |_, centres| predict_batch(&tensors, &around, centres)).concat()
}

fn predict_batch(tensors: &Tensors<Value>, around: &Neighbourhoods, centres: &[u32]) -> Vec<Patch> {
    let tape = &mut Tape::default();
    let frames: Vec<PatchFrame> = centres.iter().map(|&centre| around.frame(centre)).collect();
    let candidates: Vec<Vec<u32>> = centres.iter().map(|&centre| around.candidates(centre)).collect();
    let places = Value::constant(around.places(&candidates, &frames));
    let logits = forward(tape, tensors, "classifier", &places, around.group());
    let rows = candidates.iter().zip(logits.matrix().data().chunks_exact(around.group()));
    let kept: Vec<Vec<u32>> = rows.map(|(candidates, logits)| most_likely(candidates, logits)).collect();
    let group = kept.first().map_or(1, Vec::len);
    let map = forward(tape, tensors, "map", &Value::constant(around.places(&kept, &frames)), group);
    let in_unit = |place: &[f32], unit: f64| [0, 1].map(|axis: usize| f64::from(place[axis]) * unit);
    let patch = |(points, (rows, frame)): (Vec<u32>, (&[f32], &PatchFrame))| Patch {
        points,
        map: rows.chunks_exact(2).map(|place| in_unit(place, frame.unit)).collect(),
    };
    kept.into_iter().zip(map.matrix().data().chunks_exact(2 * group).zip(&frames)).map(patch).collect()
}

fn most_likely(candidates: &[u32], logits: &[f32]) -> Vec<u32> {
    let mut others: Vec<usize> = (1..candidates.len()).collect();
    // The sort is stable: among equal logits the nearest point comes first.
    others.sort_by(|&a, &b| logits[b].total_cmp(&logits[a]));
    others.truncate(KEPT);
    std::iter::once(0).chain(others).map(|at| candidates[at]).collect()
}
