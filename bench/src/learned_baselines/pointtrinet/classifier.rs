//! The classification network.

use super::network::{Classifier, Layer};
use super::patches::{CandidateNeighbourhoods, point_features, triangle_features};
use neural_mesh::autodiff::{Tape, Value};
use neural_mesh::linalg::Matrix;

/// Returns the probability that each query belongs to the surface.
///
/// # Shapes
/// - `queries`: indices of n candidates
/// - returns n x 1
pub fn classifier(
    tape: &mut Tape,
    net: &Classifier<Value>,
    neighbourhoods: &CandidateNeighbourhoods,
    queries: &[u32],
) -> Value {
    let of_query =
        |&q: &u32| (neighbourhoods.candidates.triangles[q as usize], neighbourhoods.nearest_points(q as usize));
    let points = point_features(neighbourhoods.vertices, &queries.iter().map(of_query).collect::<Vec<_>>());
    let triangles = triangle_features(neighbourhoods, queries);
    // Unlike in the authors' code, there is no dropout or clamping.
    let points = pool(tape, points, &net.points, queries.len());
    let triangles = pool(tape, triangles, &net.triangles, queries.len());
    let (first, others) = net.decision.split_first().expect("layers of the decision");
    let both = tape.concat_product(&points, &triangles, &first[0]);
    let both = tape.plus_row(&both, &first[1]);
    let both = tape.relu(&both);
    let logits = tape.layers(&both, &layers(others));
    tape.sigmoid(&logits)
}

/// Applies layers to rows and takes the maximum per query; zero without rows.
pub(super) fn pool(tape: &mut Tape, features: Matrix, net: &[Layer<Value>], n_queries: usize) -> Value {
    if features.n_rows() == 0 {
        let width = net.last().map_or(0, |[_, bias]| bias.matrix().n_cols());
        return Value::constant(Matrix::zeros(n_queries, width));
    }
    let group = features.n_rows() / n_queries;
    tape.layers_group_max(&Value::constant(features), &layers(net), group)
}

pub(super) fn layers(net: &[Layer<Value>]) -> Vec<[&Value; 2]> {
    net.iter().map(|layer| layer.each_ref()).collect()
}
