//! Step of the objective "uniform", which makes all scores equal.

use super::{Settings, StepResult, TrainingItem, network_gradients};
use crate::autodiff::{Tape, Value};
use crate::linalg::Matrix;
use crate::model::{Vertices, Weights, point_sampler};
use crate::simplify::edge_graph;
use rand_xoshiro::Xoshiro256PlusPlus;
use std::sync::Arc;

/// Minimises the variance of the scores, `spread = mean (s - mean s)^2`.
pub(super) fn uniform_step(
    weights: &Weights,
    item: &TrainingItem,
    _: &Settings,
    _: &mut Xoshiro256PlusPlus,
) -> Result<StepResult, String> {
    let mut tape = Tape::default();
    let parameters = weights.parameters(&mut tape);
    let points = Value::constant(Matrix::from_points(item.mesh.positions()));
    let vertices = Vertices { points: &points, normals: None };
    let rings = Arc::new(edge_graph(&item.mesh));
    let scores = point_sampler(&mut tape, &parameters.point_sampler, vertices, &rings);
    let (spread, gradient) = variance(scores.matrix().data());
    let gradient = Matrix::new(gradient.len(), 1, gradient);
    let gradients = network_gradients(&parameters, &tape.backward(&[(&scores, gradient)]));
    Ok(StepResult { terms: vec![("spread", spread)], gradients })
}

/// Returns the variance and its gradient, `2 (s - mean s) / n`.
fn variance(scores: &[f32]) -> (f64, Vec<f32>) {
    let n = scores.len().max(1) as f64;
    let mean = scores.iter().map(|&s| f64::from(s)).sum::<f64>() / n;
    let variance = scores.iter().map(|&s| (f64::from(s) - mean).powi(2)).sum::<f64>() / n;
    (variance, scores.iter().map(|&s| (2.0 * (f64::from(s) - mean) / n) as f32).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variance_has_its_golden_value_and_gradient() {
        assert_eq!(variance(&[1.0, 3.0]), (1.0, vec![-1.0, 1.0]));
        let scores = [0.3f32, -1.2, 2.0, 0.7];
        for (at, gradient) in variance(&scores).1.into_iter().enumerate() {
            let moved = |by: f32| {
                let mut scores = scores;
                scores[at] += by;
                variance(&scores).0
            };
            let difference = (moved(1e-3) - moved(-1e-3)) / 2e-3;
            assert!((difference - f64::from(gradient)).abs() < 1e-3);
        }
    }
}
