//! Training step of the objective "potamias".

use super::{
    Cloud, PointLoss, adaptive_chamfer, adaptive_weights, curvature_preservation, latent_likeness, mean_curvature,
    projection, refinement, selection,
};
use neural_mesh::autodiff::{Tape, Tensors};
use neural_mesh::linalg::Matrix;
use neural_mesh::spatial::nearest_to;
use neural_mesh::train::random::random_below;
use neural_mesh::train::{Settings, StepResult, TrainingItem, cut_patch};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::sync::Arc;

// Fewest samples of a step, since curvature estimates need neighbourhoods.
const LEAST_SAMPLES: usize = 16;
// Weight of the curvature loss, with which both it and the Chamfer loss fall; the text at hand does not give the
// paper's.
const CURVATURE: f64 = 10.0;
// Weight of the latent likeness loss, small because its gradient is the largest.
const LIKENESS: f64 = 0.1;
const PARTNERS: usize = 4;

/// Takes one training step.
pub fn potamias_step(
    tensors: &Tensors<Arc<Matrix>>,
    item: &TrainingItem,
    settings: &Settings,
    random: &mut Xoshiro256PlusPlus,
) -> Result<StepResult, String> {
    let mesh = cut_patch(item, settings, random)?;
    let n = mesh.positions().len();
    let n_samples = (n as f64 * item.ratio) as usize;
    if n_samples < LEAST_SAMPLES {
        return Err(format!("would keep fewer than {LEAST_SAMPLES} samples at the ratio of this step"));
    }
    let cloud = Cloud::new(mesh.positions()).ok_or("has all vertices in one place")?;
    let mut tape = Tape::default();
    let parameters = tensors.parameters(&mut tape);
    let latent = projection(&mut tape, &parameters, &cloud);
    let samples = selection(&cloud, latent.matrix(), n_samples, random_below(random, n) as u32);
    let refined = refinement(&mut tape, &parameters, &cloud, &latent, &samples);
    let curvature = mean_curvature(&cloud.points);
    let [chamfer, kept] = losses(&refined.points(), &cloud, &curvature, item.ratio);
    let rows = chamfer.gradient.iter().zip(&kept.gradient);
    let both: Vec<[f64; 3]> = rows.map(|(a, b)| std::array::from_fn(|axis| a[axis] + b[axis])).collect();
    let of_points = refined.backward(&both);
    // Farthest points pass no gradient, so the latent space has a loss of its own.
    let offsets: Vec<usize> = (0..PARTNERS).map(|_| 1 + random_below(random, n - 1)).collect();
    let (likeness, mut of_latent) = latent_likeness(latent.matrix(), &curvature, &offsets);
    of_latent.data_mut().iter_mut().for_each(|g| *g *= LIKENESS as f32);
    let gradients = tape.backward(&[(&refined.displacement, of_points), (&latent, of_latent)]);
    let terms = vec![("chamfer", chamfer.value), ("curvature", kept.value), ("likeness", LIKENESS * likeness)];
    Ok(StepResult { terms, gradients: parameters.gradients(&gradients) })
}

fn losses(samples: &[[f32; 3]], cloud: &Cloud, curvature: &[f64], ratio: f64) -> [PointLoss; 2] {
    let nearest = nearest_to(&cloud.points, samples, 1);
    let wanted: Vec<f64> = nearest.iter().map(|&at| curvature[at as usize]).collect();
    let chamfer = adaptive_chamfer(samples, &cloud.points, &adaptive_weights(curvature));
    let kept = curvature_preservation(samples, &wanted);
    // Squared distances grow as 1 / ratio; multiplied by the ratio, all ratios weigh alike.
    [scale_loss(chamfer, ratio), scale_loss(kept, CURVATURE)]
}

fn scale_loss(loss: PointLoss, factor: f64) -> PointLoss {
    let gradient = loss.gradient.into_iter().map(|row| row.map(|g| factor * g)).collect();
    PointLoss { value: factor * loss.value, gradient }
}
