//! Training step of the objective "dse".

use super::{
    CANDIDATES, KEPT, Loss, Neighbourhoods, Patch, PatchFrame, WalkSurface, exact_patches_around, forward, map_loss,
    neighbour_loss,
};
use neural_mesh::autodiff::{Tape, Tensors, Value};
use neural_mesh::linalg::Matrix;
use neural_mesh::spatial::farthest_points;
use neural_mesh::train::random::{random_below, shuffle_indices};
use neural_mesh::train::{Settings, StepResult, TrainingItem, cut_patch};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::sync::Arc;

// Patches per step, as in the paper's program.
const PATCHES: usize = 64;
// Weight of the map's loss, with which it starts as large as the classifier's.
const MAP: f64 = 10.0;

struct PatchBatch<'a> {
    around: Neighbourhoods<'a>,
    centres: Vec<u32>,
    exact: Vec<Patch>,
    frames: Vec<PatchFrame>,
}

/// Takes one training step.
pub fn dse_step(
    tensors: &Tensors<Arc<Matrix>>,
    item: &TrainingItem,
    settings: &Settings,
    random: &mut Xoshiro256PlusPlus,
) -> Result<StepResult, String> {
    let mesh = cut_patch(item, settings, random)?;
    let n = mesh.positions().len();
    let n_samples = (n as f64 * item.ratio) as usize;
    let samples = farthest_points(mesh.positions(), n_samples, random_below(random, n) as u32);
    if samples.len() <= CANDIDATES {
        return Err(format!("would keep no more than {CANDIDATES} samples at the ratio of this step"));
    }
    let points: Vec<[f32; 3]> = samples.iter().map(|&v| mesh.positions()[v as usize]).collect();
    let batch = PatchBatch::new(&WalkSurface::new(&mesh), &samples, &points, random)?;
    let mut tape = Tape::default();
    let parameters = tensors.parameters(&mut tape);
    let (logits, of_logits) = batch.classify(&mut tape, &parameters);
    // The map network gets the exact neighbours, not the classifier's, so that both networks learn independently.
    let (map, of_map) = batch.predict_map(&mut tape, &parameters);
    let gradients = tape.backward(&[(&logits, of_logits.gradient), (&map, of_map.gradient)]);
    let terms = vec![("neighbours", of_logits.value), ("map", of_map.value)];
    Ok(StepResult { terms, gradients: parameters.gradients(&gradients) })
}

impl<'a> PatchBatch<'a> {
    fn new(
        surface: &WalkSurface,
        samples: &[u32],
        points: &'a [[f32; 3]],
        random: &mut Xoshiro256PlusPlus,
    ) -> Result<Self, String> {
        let around = Neighbourhoods::new(points);
        let mut drawn = shuffle_indices(random, points.len());
        drawn.truncate(PATCHES);
        let mut exact = exact_patches_around(surface, samples, &drawn, KEPT);
        // The networks take groups of equal size.
        exact.retain(|patch| patch.points.len() == KEPT + 1);
        if exact.is_empty() {
            return Err(format!("has no component with more than {KEPT} of the samples drawn"));
        }
        let centres: Vec<u32> = exact.iter().map(|patch| patch.points[0]).collect();
        let frames = centres.iter().map(|&centre| around.frame(centre)).collect();
        Ok(Self { around, centres, exact, frames })
    }

    fn classify(&self, tape: &mut Tape, tensors: &Tensors<Value>) -> (Value, Loss) {
        let candidates: Vec<Vec<u32>> = self.centres.iter().map(|&centre| self.around.candidates(centre)).collect();
        let pairs = candidates.iter().zip(&self.exact);
        let labels: Vec<bool> =
            pairs.flat_map(|(all, exact)| all.iter().map(|point| exact.points.contains(point))).collect();
        let places = Value::constant(self.around.places(&candidates, &self.frames));
        let logits = forward(tape, tensors, "classifier", &places, self.around.group());
        let loss = neighbour_loss(logits.matrix(), &labels, self.around.group());
        (logits, loss)
    }

    fn predict_map(&self, tape: &mut Tape, tensors: &Tensors<Value>) -> (Value, Loss) {
        let points: Vec<Vec<u32>> = self.exact.iter().map(|patch| patch.points.clone()).collect();
        let places = Value::constant(self.around.places(&points, &self.frames));
        let map = forward(tape, tensors, "map", &places, KEPT + 1);
        let pairs = self.exact.iter().zip(&self.frames);
        let exact: Vec<[f64; 2]> =
            pairs.flat_map(|(patch, frame)| patch.map.iter().map(|at| at.map(|x| x / frame.unit))).collect();
        let loss = scale_loss(map_loss(map.matrix(), &exact, KEPT + 1), MAP);
        (map, loss)
    }
}

fn scale_loss(mut loss: Loss, factor: f64) -> Loss {
    loss.value *= factor;
    loss.gradient.data_mut().iter_mut().for_each(|g| *g *= factor as f32);
    loss
}
