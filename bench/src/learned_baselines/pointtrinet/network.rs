//! Tensors of both networks by name.

use crate::learned_baselines::scale_width;
use neural_mesh::autodiff::{Tensors, WeightsError};
use neural_mesh::linalg::Matrix;
use std::sync::Arc;

/// Weights, n_in x n_out, and bias, 1 x n_out.
pub type Layer<T> = [T; 2];

/// Both networks; `T` is a shape, a matrix or a value on a tape.
#[derive(Clone, Debug, PartialEq)]
pub struct PointTriNet<T> {
    /// Network that classifies triangles.
    pub classifier: Classifier<T>,
    /// Network that proposes triangles.
    pub proposals: Proposals<T>,
}

/// The classification network.
#[derive(Clone, Debug, PartialEq)]
pub struct Classifier<T> {
    /// Layers of nearby points, of widths 6-64-128-1024, before a maximum.
    pub points: Vec<Layer<T>>,
    /// Layers of nearby triangles, of widths 13-64-128-1024, before a maximum.
    pub triangles: Vec<Layer<T>>,
    /// Layers of both maxima, of widths 2048-512-256-1.
    pub decision: Vec<Layer<T>>,
}

/// The proposal network.
#[derive(Clone, Debug, PartialEq)]
pub struct Proposals<T> {
    /// Layers of nearby points, of widths 6-64-64-128, before a maximum.
    pub points: Vec<Layer<T>>,
    /// First weights of `score` for the maximum, 128 x 128.
    pub pooled: T,
    /// Layers of a point joined with the maximum, of widths 134-128-64-64-1.
    pub score: Vec<Layer<T>>,
}

/// Number of features of a point.
pub const POINT_NUMBERS: usize = 6;
/// Number of features of a triangle.
pub const TRIANGLE_NUMBERS: usize = 13;

const CLASSIFIER_POOLED: [usize; 3] = [64, 128, 1024];
const DECISION: [usize; 2] = [512, 256];
const PROPOSALS_POOLED: [usize; 3] = [64, 64, 128];
const SCORE: [usize; 3] = [128, 64, 64];

const ROWS: [(&str, usize); 5] = [
    ("classifier.points", 3),
    ("classifier.triangles", 3),
    ("classifier.decision", 3),
    ("proposals.points", 3),
    ("proposals.score", 4),
];

impl<T: Clone> PointTriNet<T> {
    /// Makes the networks of named tensors.
    ///
    /// # Errors
    /// [`WeightsError::Missing`] names the first missing tensor.
    ///
    /// ```
    /// use neural_mesh_bench::learned_baselines::pointtrinet::{PointTriNet, shapes};
    /// let net = PointTriNet::from_tensors(&shapes(1.0)).unwrap();
    /// let decision: Vec<[usize; 2]> = net.classifier.decision.iter().map(|&[weights, _]| weights).collect();
    /// assert_eq!(decision, [[2048, 512], [512, 256], [256, 1]]);
    /// ```
    pub fn from_tensors(tensors: &Tensors<T>) -> Result<Self, WeightsError> {
        let layer = |name: &str, i: usize| -> Result<Layer<T>, WeightsError> {
            let named = |of: &str| tensors.find_tensor(&format!("{name}_{i}.{of}")).cloned();
            Ok([named("weights")?, named("bias")?])
        };
        let [points, triangles, decision, edge_points, score] =
            ROWS.map(|(name, n)| (0..n).map(|i| layer(name, i)).collect::<Result<Vec<_>, _>>());
        Ok(Self {
            classifier: Classifier { points: points?, triangles: triangles?, decision: decision? },
            proposals: Proposals {
                points: edge_points?,
                pooled: tensors.find_tensor("proposals.pooled")?.clone(),
                score: score?,
            },
        })
    }
}

/// Returns the shapes of all tensors.
pub fn shapes(width_share: f64) -> Tensors<[usize; 2]> {
    let part =
        |widths: &[usize]| -> Vec<usize> { widths.iter().map(|&width| scale_width(width, width_share)).collect() };
    let [classifier, proposals] = [part(&CLASSIFIER_POOLED), part(&PROPOSALS_POOLED)];
    let after = |n_in: usize, widths: &[usize]| [&[n_in], widths].concat();
    let (both, of_edge) = (2 * classifier[2], proposals[2]);
    let rows = [
        after(POINT_NUMBERS, &classifier),
        after(TRIANGLE_NUMBERS, &classifier),
        after(both, &[part(&DECISION), vec![1]].concat()),
        after(POINT_NUMBERS, &proposals),
        after(POINT_NUMBERS, &[part(&SCORE), vec![1]].concat()),
    ];
    let mut shapes = Tensors::default();
    for ((name, _), widths) in ROWS.iter().zip(&rows) {
        for (i, pair) in widths.windows(2).enumerate() {
            shapes.push(format!("{name}_{i}.weights"), [pair[0], pair[1]]);
            shapes.push(format!("{name}_{i}.bias"), [1, pair[1]]);
        }
    }
    shapes.push("proposals.pooled", [of_edge, rows[4][1]]);
    shapes
}

/// Returns random initial tensors for probabilities near one half.
pub fn initial_tensors(width_share: f64, seed: u64) -> Tensors<Arc<Matrix>> {
    let is_last = |name: &str| matches!(name, "classifier.decision_2.weights" | "proposals.score_3.weights");
    shapes(width_share).draw_scaled(seed, |name| if is_last(name) { 0.1 } else { 1.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_printed_sizes_are_those_of_the_paper() {
        let mlp = |widths: &[usize]| widths.windows(2).map(|pair| (pair[0] + 1) * pair[1]).sum::<usize>();
        let classifier = mlp(&[6, 64, 128, 1024]) + mlp(&[13, 64, 128, 1024]) + mlp(&[2048, 512, 256, 1]);
        let proposals = mlp(&[6, 64, 64, 128]) + mlp(&[134, 128, 64, 64, 1]);
        assert_eq!(shapes(1.0).n_parameters(), classifier + proposals);
        assert_eq!(shapes(0.25).get("classifier.points_2.weights"), Some(&[32, 256]));
    }
}
