//! The classification network.

use super::network::DEPTH;
use super::patches::{CandidateNeighbourhoods, point_features, triangle_features};
use crate::learned_baselines::layers;
use neural_mesh::autodiff::{Tape, Tensors, Value};
use neural_mesh::linalg::Matrix;

/// Returns the probability that each query belongs to the surface.
///
/// # Shapes
/// - `queries`: indices of n candidates
/// - returns n x 1
pub fn classifier(
    tape: &mut Tape,
    tensors: &Tensors<Value>,
    neighbourhoods: &CandidateNeighbourhoods,
    queries: &[u32],
) -> Value {
    let of_query =
        |&q: &u32| (neighbourhoods.candidates.triangles[q as usize], neighbourhoods.nearest_points(q as usize));
    let points = point_features(neighbourhoods.vertices, &queries.iter().map(of_query).collect::<Vec<_>>());
    let triangles = triangle_features(neighbourhoods, queries);
    // Unlike in the authors' code, there is no dropout or clamping.
    let points = pool(tape, points, &layers(tensors, "classifier.points", DEPTH), queries.len());
    let triangles = pool(tape, triangles, &layers(tensors, "classifier.triangles", DEPTH), queries.len());
    let decision = layers(tensors, "classifier.decision", DEPTH);
    let both = tape.concat_product(&points, &triangles, decision[0][0]);
    let both = tape.plus_row(&both, decision[0][1]);
    let both = tape.relu(&both);
    let logits = tape.layers(&both, &decision[1..]);
    tape.sigmoid(&logits)
}

/// Applies layers to rows and takes the maximum per query; zero without rows.
pub(super) fn pool(tape: &mut Tape, features: Matrix, layers: &[[&Value; 2]], n_queries: usize) -> Value {
    if features.n_rows() == 0 {
        let width = layers.last().map_or(0, |[_, bias]| bias.matrix().n_cols());
        return Value::constant(Matrix::zeros(n_queries, width));
    }
    let group = features.n_rows() / n_queries;
    tape.layers_group_max(&Value::constant(features), layers, group)
}
