//! The whole network as one function of weights and positions, with gradients.

use super::{column, gradient_of_points, numbers};
use crate::autodiff::{Tape, Value};
use crate::linalg::{Csr, Matrix};
use crate::model::{CandidateFaces, Network, Vertices, Weights, edge_predictor, face_classifier, point_sampler, prior};
use std::sync::Arc;

/// Graphs, samples and candidate faces of a mesh; gradients treat these choices as constants.
#[derive(Clone, Debug)]
pub struct Connectivity {
    /// The edges of the mesh, n x n.
    pub rings: Arc<Csr>,
    /// Unit normals of the vertices, for networks that use them.
    pub normals: Option<Vec<[f32; 3]>>,
    /// The sampled vertices, n_samples.
    pub samples: Vec<u32>,
    /// Samples joined by the mesh, n_samples x n_samples, symmetric.
    pub original: Arc<Csr>,
    /// G_ext, n_samples x n_samples, symmetric.
    pub graph: Arc<Csr>,
    /// The candidate faces, over samples.
    pub candidates: CandidateFaces,
    /// G_tri, from [`triangle_graph`](crate::model::triangle_graph).
    pub triangle_graph: Arc<Csr>,
}

/// Outputs of the network, or a loss's gradients by them; an empty gradient means zeros.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outputs {
    /// One score per vertex of the mesh, Sec. 3.1.
    pub scores: Vec<f32>,
    /// S, Eq. (2), one value per entry of G_ext.
    pub attention: Vec<f32>,
    /// A_s, Eq. (3), one value per entry of G_ext.
    pub adjacency: Vec<f32>,
    /// p_init, one value per candidate.
    pub prior: Vec<f32>,
    /// One probability per candidate, Sec. 3.3.
    pub probabilities: Vec<f32>,
}

/// Outputs of the network, with the data for the backward pass.
pub struct NetworkPass {
    /// The outputs.
    pub outputs: Outputs,
    tape: Tape,
    net: Network<Value>,
    points: Value,
    results: [Value; 5],
}

/// Gradients of a loss that depends on the outputs.
#[derive(Clone, Debug, PartialEq)]
pub struct NetworkGradients {
    /// Gradient by each tensor.
    pub tensors: Network<Matrix>,
    /// Gradient by the positions of the mesh's vertices.
    pub points: Vec<[f32; 3]>,
}

impl Network<Matrix> {
    /// Returns the entries of all tensors in one list, tensor by tensor.
    ///
    /// ```
    /// # use neural_mesh_network as neural_mesh;
    /// use neural_mesh::model::Weights;
    /// let weights = Weights::random(1);
    /// let tensors = weights.tensors().map(|_, matrix| matrix.as_ref().clone());
    /// assert_eq!(tensors.flat().len(), weights.architecture().n_parameters());
    /// ```
    pub fn flat(&self) -> Vec<f32> {
        let mut entries = Vec::new();
        self.map(|_, matrix| entries.extend_from_slice(matrix.data()));
        entries
    }
}

/// Runs the whole network over the vertices of a mesh and records the operations.
///
/// # Shapes
/// - `points`: from [`in_edge_lengths`](crate::model::in_edge_lengths)
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::{linalg::Csr, model};
/// use std::sync::Arc;
/// let all = Arc::new(Csr::from_edges(4, [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]));
/// let points = model::in_edge_lengths(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], &all);
/// let candidates = model::candidate_faces(&all, &[1.0; 12], &[]);
/// let triangle_graph = model::triangle_graph(&points, &candidates.triangles, 3).into();
/// let (rings, original, graph, normals) = (all.clone(), all.clone(), all, None);
/// let samples = vec![0, 1, 2, 3];
/// let chosen = model::Connectivity { rings, normals, samples, original, graph, candidates, triangle_graph };
/// let pass = model::network_forward(&model::Weights::random(1), &points, &chosen);
/// let loss = model::Outputs { probabilities: vec![1.0; 4], ..model::Outputs::default() };
/// let gradients = model::network_backward(&pass, &loss);
/// assert_eq!((gradients.tensors.flat().len(), gradients.points.len()), (14_658, 4));
/// ```
pub fn network_forward(weights: &Weights, points: &[[f32; 3]], connectivity: &Connectivity) -> NetworkPass {
    let mut tape = Tape::default();
    let net = weights.parameters(&mut tape);
    let points = tape.parameter(Matrix::from_points(points));
    let results = results(&mut tape, &net, &points, connectivity);
    let [scores, attention, adjacency, prior, probabilities] = results.each_ref().map(numbers);
    let outputs = Outputs { scores, attention, adjacency, prior, probabilities };
    NetworkPass { outputs, tape, net, points, results }
}

fn results(tape: &mut Tape, net: &Network<Value>, points: &Value, connectivity: &Connectivity) -> [Value; 5] {
    let Connectivity { rings, normals, samples, original, graph, candidates, triangle_graph } = connectivity;
    let normals = normals.as_ref().map(|normals| Value::constant(Matrix::from_points(normals)));
    let vertices = Vertices { points, normals: normals.as_ref() };
    let scores = point_sampler(tape, &net.point_sampler, vertices, rings);
    let samples = tape.gather(points, samples);
    let edges = edge_predictor(tape, &net.edge_predictor, &samples, graph, original);
    let prior = prior(tape, &edges.adjacency, candidates);
    let triangles = &candidates.triangles;
    let probabilities = face_classifier(tape, &net.face_classifier, &samples, triangles, triangle_graph, &prior);
    [scores, edges.attention, edges.adjacency, prior, probabilities]
}

/// Computes the gradients of [`network_forward`] from those of the outputs.
pub fn network_backward(pass: &NetworkPass, gradient: &Outputs) -> NetworkGradients {
    let Outputs { scores, attention, adjacency, prior, probabilities } = gradient;
    let lists = [scores, attention, adjacency, prior, probabilities];
    let given = pass.results.iter().zip(lists).filter(|(_, list)| !list.is_empty());
    let given: Vec<(&Value, Matrix)> = given.map(|(value, list)| (value, column(list))).collect();
    let gradients = pass.tape.backward(&given);
    let tensors = pass.net.map(|_, value| gradients.or_zero(value));
    NetworkGradients { tensors, points: gradient_of_points(&gradients, &pass.points) }
}
