//! Step of the objective "bending": learns scores that follow the surface's bending.

use super::scored_mesh::score_mesh;
use super::{Settings, StepResult, TrainingItem};
use crate::model::Weights;
use crate::simplify::{bending_scores, vertex_areas};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Computes the area-weighted variance of the difference between scores and bending, and its gradient.
pub(super) fn bending_step(
    weights: &Weights,
    item: &TrainingItem,
    _: &Settings,
    _: &mut Xoshiro256PlusPlus,
) -> Result<StepResult, String> {
    let mesh = &item.mesh;
    let (scored, areas) = (score_mesh(weights, mesh), vertex_areas(mesh));
    let wanted = bending_scores(&scored.points, &scored.normals, &areas, &scored.rings).ok_or("is flat everywhere")?;
    let (error, gradient) = squared_error(scored.scores.matrix().data(), &wanted, &areas);
    Ok(StepResult { terms: vec![("teacher", error)], gradients: scored.backward(gradient) })
}

fn squared_error(scores: &[f32], wanted: &[f32], areas: &[f64]) -> (f64, Vec<f32>) {
    let total: f64 = areas.iter().sum();
    let differences: Vec<f64> = scores.iter().zip(wanted).map(|(s, w)| f64::from(*s) - f64::from(*w)).collect();
    let mean = differences.iter().zip(areas).map(|(d, area)| d * area).sum::<f64>() / total;
    let error = differences.iter().zip(areas).map(|(d, area)| (d - mean).powi(2) * area).sum::<f64>() / total;
    let slope = |(d, area): (&f64, &f64)| (2.0 * (d - mean) * area / total) as f32;
    (error, differences.iter().zip(areas).map(slope).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_has_its_golden_value_and_gradient() {
        // Score minus bending is 1 and 3, with areas 3 and 1: the mean is 1.5.
        let (error, gradient) = squared_error(&[2.0, 3.0], &[1.0, 0.0], &[3.0, 1.0]);
        assert_eq!((error, gradient), (0.75 * 0.25 + 0.25 * 2.25, vec![-0.75, 0.75]));
    }
}
