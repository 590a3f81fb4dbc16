//! The classification network: how likely a triangle belongs to the surface.

use super::network::{Classifier, Layer};
use super::patches::{Neighbourhoods, point_features, triangle_features};
use neural_mesh::autodiff::{Tape, Value};
use neural_mesh::linalg::Matrix;

/// The probability of each query: an MLP over each of its 64 nearest points, another over each of its 64 nearest triangles,
/// the largest of either, and an MLP over both.
///
/// The authors' code has dropout in the last of them, which here is left out: no patch is seen twice. It also pulls
/// probabilities off 0 and 1, which losses without logarithms and quotients do not need.
///
/// # Shapes
/// - `queries`: indices of n candidates
/// - returns n x 1
pub fn classifier(tape: &mut Tape, net: &Classifier<Value>, neighbourhoods: &Neighbourhoods, queries: &[u32]) -> Value {
    let of_query = |&q: &u32| (neighbourhoods.candidates.triangles[q as usize], neighbourhoods.points_of(q as usize));
    let points = point_features(neighbourhoods.vertices, &queries.iter().map(of_query).collect::<Vec<_>>());
    let triangles = triangle_features(neighbourhoods, queries);
    let points = pooled(tape, points, &net.points, queries.len());
    let triangles = pooled(tape, triangles, &net.triangles, queries.len());
    let (first, others) = net.decision.split_first().expect("layers of the decision");
    let both = tape.concat_product(&points, &triangles, &first[0]);
    let both = tape.plus_row(&both, &first[1]);
    let both = tape.relu(&both);
    let logits = tape.layers(&both, &layers(others));
    tape.sigmoid(&logits)
}

/// The largest over each query of what the layers make of its rows; zero where a query has no rows.
pub(super) fn pooled(tape: &mut Tape, features: Matrix, net: &[Layer<Value>], n_queries: usize) -> Value {
    if features.n_rows() == 0 {
        let width = net.last().map_or(0, |[_, bias]| bias.matrix().n_cols());
        return Value::constant(Matrix::zeros(n_queries, width));
    }
    let group = features.n_rows() / n_queries;
    tape.layers_group_max(&Value::constant(features), &layers(net), group)
}

/// Layers as the tape takes them.
pub(super) fn layers(net: &[Layer<Value>]) -> Vec<[&Value; 2]> {
    net.iter().map(|layer| layer.each_ref()).collect()
}
