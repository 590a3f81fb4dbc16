//! The three stages over slices, without gradients.

use super::tiles::{TILE, compute_in_tiles};
use super::{
    Architecture, CandidateFaces, PointSampler, Vertices, Weights, candidate_faces, edge_predictor, extended_graph,
    face_classifier, in_edge_lengths, point_sampler, prior, triangle_graph,
};
use crate::autodiff::{Tape, Value};
use crate::linalg::{Csr, Matrix, neighbour_max_two_products, product};
use crate::spatial::coherent_order;
use std::sync::Arc;

/// Scores every vertex with the Point Sampler, Sec. 3.1; higher scores are sampled sooner.
///
/// # Shapes
/// - `points`: from [`in_edge_lengths`](super::in_edge_lengths)
/// - `normals`: unit vectors, for networks that use them
/// - `rings`: n x n, the edges of the mesh
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::{linalg::Csr, model::{Weights, in_edge_lengths, vertex_scores}};
/// let rings = std::sync::Arc::new(Csr::from_edges(3, [[0, 1], [1, 2], [2, 0]]));
/// let points = in_edge_lengths(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &rings);
/// assert_eq!(vertex_scores(&Weights::random(1), &points, None, &rings).len(), 3);
/// ```
pub fn vertex_scores(
    weights: &Weights,
    points: &[[f32; 3]],
    normals: Option<&[[f32; 3]]>,
    rings: &Arc<Csr>,
) -> Vec<f32> {
    let score = |some: &[u32], rings: &Arc<Csr>| {
        let gather = |rows: &[[f32; 3]]| Matrix::from_owned_points(some.iter().map(|&v| rows[v as usize]).collect());
        scores(weights, gather(points), normals.map(gather), rings)
    };
    let n_hops = weights.architecture().point_sampler_layers;
    compute_in_tiles(rings, || coherent_order(points), (TILE, n_hops), score)
}

/// Scores every vertex of a surface of any scale with [`vertex_scores`].
///
/// # Shapes
/// - `normals`: unit vectors
/// - `rings`: n x n, the edges of the mesh
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::{linalg::Csr, model::{Weights, surface_scores}};
/// let rings = std::sync::Arc::new(Csr::from_edges(3, [[0, 1], [1, 2], [2, 0]]));
/// let positions = [[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0]];
/// assert_eq!(surface_scores(&Weights::random(1), &positions, &[[0.0, 0.0, 1.0]; 3], &rings).len(), 3);
/// ```
pub fn surface_scores<P: Copy + Into<[f32; 3]>>(
    weights: &Weights,
    positions: &[P],
    normals: &[P],
    rings: &Arc<Csr>,
) -> Vec<f32> {
    let points = Matrix::from_owned_points(in_edge_lengths(positions, rings));
    let normals = Matrix::from_owned_points(normals.iter().map(|&normal| normal.into()).collect());
    scores(weights, points, Some(normals), rings)
}

fn scores(weights: &Weights, points: Matrix, normals: Option<Matrix>, rings: &Arc<Csr>) -> Vec<f32> {
    let net = weights.constants().point_sampler;
    if net.hidden.is_none() && net.dev_convs.first().is_some_and(|layer| layer.theta.matrix().n_rows() == 3) {
        return scores_of_positions(&net, &points, rings);
    }
    let (points, normals) = (Value::constant(points), normals.map(Value::constant));
    let vertices = Vertices { points: &points, normals: normals.as_ref() };
    point_sampler(&mut Tape::default(), &net, vertices, rings).matrix().data().to_vec()
}

/// Scores with the bits of [`point_sampler`], without storing the features between two DevConv.
fn scores_of_positions(net: &PointSampler<Value>, points: &Matrix, rings: &Csr) -> Vec<f32> {
    let mut layers = net.dev_convs.iter().peekable();
    let mut mapped = layers.peek().map_or_else(|| points.clone(), |first| product(points, first.theta.matrix(), &[]));
    while let Some(layer) = layers.next() {
        let next = match layers.peek() {
            Some(next) => (next.theta.matrix(), [].as_slice()),
            None => (net.score.weights.matrix(), net.score.bias.matrix().data()),
        };
        mapped = neighbour_max_two_products(&mapped, rings, layer.phi.matrix(), next);
    }
    mapped.into_data()
}

/// The graph G_ext of the samples, with the Edge Predictor's attention and predicted adjacency of each edge.
#[derive(Clone, Debug, PartialEq)]
pub struct PredictedEdges {
    /// G_ext with loops, n x n, symmetric.
    pub graph: Arc<Csr>,
    /// S, Eq. (2), one value per entry of the graph.
    pub attention: Vec<f32>,
    /// A_s, Eq. (3), one value per entry of the graph.
    pub adjacency: Vec<f32>,
}

/// Extends the connectivity of the samples and predicts its edges, Sec. 3.2.
///
/// G_ext joins each sample with itself, too; otherwise A_s is blurred, since no sample attends to itself.
///
/// # Shapes
/// - `points`: the samples, from [`in_edge_lengths`](super::in_edge_lengths) over `original`
/// - `original`: n x n, samples joined by the mesh, symmetric
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::{linalg::Csr, model::{Weights, predict_edges}};
/// let points = [[0.0; 3], [0.6, 0.0, 0.0], [0.0, 0.6, 0.0]];
/// let edges = predict_edges(&Weights::random(1), &points, &Csr::from_edges(3, [[0, 1], [1, 2]]).into());
/// assert_eq!(edges.adjacency.len(), 9);
/// ```
pub fn predict_edges(weights: &Weights, points: &[[f32; 3]], original: &Arc<Csr>) -> PredictedEdges {
    let graph = Arc::new(extended_graph(points, original, weights.architecture().edge_knn).with_loops());
    let points = Value::constant(Matrix::from_points(points));
    let net = weights.constants().edge_predictor;
    let edges = edge_predictor(&mut Tape::default(), &net, &points, &graph, original);
    let [attention, adjacency] = [edges.attention, edges.adjacency].map(|values| values.matrix().data().to_vec());
    PredictedEdges { graph, attention, adjacency }
}

/// Candidate faces with their priors and probabilities.
#[derive(Clone, Debug, PartialEq)]
pub struct PredictedFaces {
    /// The candidate faces.
    pub candidates: CandidateFaces,
    /// Prior p_init of each candidate.
    pub prior: Vec<f32>,
    /// Probability of each candidate, in 0..=1.
    pub probabilities: Vec<f32>,
}

/// Chooses the candidates that the Face Classifier judges; returns them with G_tri.
///
/// # Shapes
/// - `graph`, `adjacency`, `original`: as for [`candidate_faces`]
#[doc(hidden)]
pub fn choose_candidates(
    sizes: &Architecture,
    points: &[[f32; 3]],
    (graph, adjacency): (&Csr, &[f32]),
    original: &[[u32; 3]],
) -> (CandidateFaces, Arc<Csr>) {
    let mut candidates = candidate_faces(graph, adjacency, original);
    if sizes.face_candidates > 0 {
        candidates = candidates.with_largest_prior(sizes.face_candidates * points.len(), adjacency, original);
    }
    candidates = candidates.in_coherent_order(points);
    let neighbours = match sizes.face_knn {
        0 => candidates.across_edges(graph.n_entries()),
        k => triangle_graph(points, &candidates.triangles, k),
    };
    (candidates, neighbours.into())
}

/// Finds candidate faces and classifies them, Secs. 3.2 and 3.3.
///
/// # Shapes
/// - `points`: the samples, scaled to mean edge length 1, ordered by original vertex
/// - `original`: as for [`candidate_faces`]
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::{linalg::Csr, model::{Weights, predict_edges, predict_faces}};
/// let weights = Weights::random(1);
/// let points = [[0.0; 3], [0.6, 0.0, 0.0], [0.0, 0.6, 0.0]];
/// let edges = predict_edges(&weights, &points, &Csr::from_edges(3, [[0, 1], [1, 2], [2, 0]]).into());
/// let faces = predict_faces(&weights, &points, &edges, &[[0, 1, 2]]);
/// assert_eq!(faces.candidates.triangles, [[0, 1, 2]]);
/// ```
pub fn predict_faces(
    weights: &Weights,
    points: &[[f32; 3]],
    edges: &PredictedEdges,
    original: &[[u32; 3]],
) -> PredictedFaces {
    let predicted = (&*edges.graph, edges.adjacency.as_slice());
    let (candidates, graph) = choose_candidates(weights.architecture(), points, predicted, original);
    let adjacency = Value::constant(Matrix::new(edges.adjacency.len(), 1, edges.adjacency.clone()));
    let prior = prior(&mut Tape::default(), &adjacency, &candidates).matrix().data().to_vec();
    let net = weights.constants().face_classifier;
    let points = Value::constant(Matrix::from_points(points));
    let classify = |some: &[u32], graph: &Arc<Csr>| {
        let triangles: Vec<[u32; 3]> = some.iter().map(|&at| candidates.triangles[at as usize]).collect();
        let prior = some.iter().map(|&at| prior[at as usize]).collect();
        let prior = Value::constant(Matrix::new(some.len(), 1, prior));
        let probabilities = face_classifier(&mut Tape::default(), &net, &points, &triangles, graph, &prior);
        probabilities.matrix().data().to_vec()
    };
    // The candidates are already sorted such that near ones are near in memory.
    let order = || (0..candidates.triangles.len() as u32).collect();
    let probabilities = compute_in_tiles(&graph, order, (TILE, net.tri_convs.len()), classify);
    PredictedFaces { candidates, prior, probabilities }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::test_values::{ragged_graph, random};

    #[test]
    fn scores_of_positions_have_the_bits_of_the_sampler() {
        let (weights, rings) = (Weights::random(3), Arc::new(ragged_graph(201)));
        let (net, points) = (weights.constants().point_sampler, random(201, 3, 1));
        let values = Value::constant(points.clone());
        let vertices = Vertices { points: &values, normals: None };
        let scores = point_sampler(&mut Tape::default(), &net, vertices, &rings);
        assert_eq!(scores_of_positions(&net, &points, &rings), scores.matrix().data());
    }
}
