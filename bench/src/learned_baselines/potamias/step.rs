//! The step of the objective "potamias": a cloud simplified by the network of this module, judged by
//! the adaptive Chamfer distance and the preservation of curvature.
//!
//! Which points are drawn is held; the gradient reaches all tensors through the refinement, which looks at the latent space, and
//! the projection through the likeness of points in that space.

use super::{
    Cloud, PointLoss, Potamias, adaptive_chamfer, adaptive_weights, curvature_preservation, latent_likeness,
    mean_curvature, projection, refinement, selection,
};
use neural_mesh::autodiff::{Tape, Tensors};
use neural_mesh::linalg::Matrix;
use neural_mesh::spatial::nearest_to;
use neural_mesh::train::random::below;
use neural_mesh::train::{Item, Settings, Step, piece};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::sync::Arc;

/// Fewer samples than this have no neighbourhoods to take a curvature from.
const LEAST_SAMPLES: usize = 16;
/// Weight of the curvature against the distance, chosen so that both fall: the paper's is not in the text at hand.
const CURVATURE: f64 = 10.0;
/// Weight of the likeness in the latent space, so that its gradient, which is larger than the others', leaves them room.
const LIKENESS: f64 = 0.1;
/// Others that each point's row of the latent space is compared with.
const PARTNERS: usize = 4;

/// One step: distances in units of the samples' own, about, so that all ratios count alike.
pub fn potamias_step(
    tensors: &Tensors<Arc<Matrix>>,
    item: &Item,
    settings: &Settings,
    random: &mut Xoshiro256PlusPlus,
) -> Result<Step, String> {
    let mesh = piece(item, settings, random)?;
    let n = mesh.positions().len();
    let n_samples = (n as f64 * item.ratio) as usize;
    if n_samples < LEAST_SAMPLES {
        return Err(format!("has fewer than {LEAST_SAMPLES} samples at this ratio"));
    }
    let cloud = Cloud::new(mesh.positions()).ok_or("has all vertices in one place")?;
    let mut tape = Tape::default();
    let parameters = tensors.parameters(&mut tape);
    let net = Potamias::of(&parameters).map_err(|error| error.to_string())?;
    let latent = projection(&mut tape, &net, &cloud);
    let samples = selection(&cloud, latent.matrix(), n_samples, below(random, n) as u32);
    let refined = refinement(&mut tape, &net, &cloud, &latent, &samples);
    let curvature = mean_curvature(&cloud.points);
    let [chamfer, kept] = losses(&refined.points(), &cloud, &curvature, item.ratio);
    let of_points = refined.backward(&sum(&chamfer, &kept));
    let offsets: Vec<usize> = (0..PARTNERS).map(|_| 1 + below(random, n - 1)).collect();
    let (likeness, mut of_latent) = latent_likeness(latent.matrix(), &curvature, &offsets);
    of_latent.data_mut().iter_mut().for_each(|g| *g *= LIKENESS as f32);
    let gradients = tape.backward(&[(&refined.displacement, of_points), (&latent, of_latent)]);
    let terms = vec![("chamfer", chamfer.value), ("curvature", kept.value), ("likeness", LIKENESS * likeness)];
    Ok(Step { terms, gradients: parameters.gradients(&gradients) })
}

/// The losses of the samples, with their weights.
fn losses(samples: &[[f32; 3]], cloud: &Cloud, curvature: &[f64], ratio: f64) -> [PointLoss; 2] {
    let nearest = nearest_to(&cloud.points, samples, 1);
    let wanted: Vec<f64> = nearest.iter().map(|&at| curvature[at as usize]).collect();
    let chamfer = adaptive_chamfer(samples, &cloud.points, &adaptive_weights(curvature));
    let kept = curvature_preservation(samples, &wanted);
    [times(chamfer, ratio), times(kept, CURVATURE)]
}

fn times(loss: PointLoss, factor: f64) -> PointLoss {
    let gradient = loss.gradient.into_iter().map(|row| row.map(|g| factor * g)).collect();
    PointLoss { value: factor * loss.value, gradient }
}

/// The sum of the gradients.
fn sum(one: &PointLoss, other: &PointLoss) -> Vec<[f64; 3]> {
    let rows = one.gradient.iter().zip(&other.gradient);
    rows.map(|(a, b)| std::array::from_fn(|axis| a[axis] + b[axis])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use neural_mesh::mesh::shapes;
    use neural_mesh::train::{Moments, adam_step};
    use rand_xoshiro::rand_core::SeedableRng;

    #[test]
    fn steps_on_one_cloud_lower_the_loss() {
        let settings = Settings::from_toml("objective = \"potamias\"").unwrap();
        let item = Item { name: "sphere".into(), mesh: shapes::wavy_sphere(4, 5.0), ratio: 0.1 };
        let mut tensors = crate::learned_baselines::potamias::drawn(0.25, 1);
        let mut moments = Moments::zero(&tensors.map(|_, matrix| matrix.shape()));
        let mut totals = Vec::new();
        for _ in 0..12 {
            let random = &mut Xoshiro256PlusPlus::seed_from_u64(0);
            let step = potamias_step(&tensors, &item, &settings, random).unwrap();
            totals.push(step.total());
            tensors = adam_step(&tensors, &step.gradients, &mut moments, &settings, 0.003);
        }
        assert!(totals[11] < 0.97 * totals[0], "{totals:?}");
    }

    #[test]
    fn what_is_too_small_is_said() {
        let settings = Settings::from_toml("").unwrap();
        let item = Item { name: "box".into(), mesh: shapes::cuboid([1.0; 3], 1), ratio: 0.5 };
        let tensors = crate::learned_baselines::potamias::drawn(0.25, 1);
        let random = &mut Xoshiro256PlusPlus::seed_from_u64(0);
        assert!(potamias_step(&tensors, &item, &settings, random).unwrap_err().contains("fewer than 16"));
    }
}
