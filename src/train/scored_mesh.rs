//! The Point Sampler on a mesh, recorded on a tape.

use super::network_gradients;
use crate::autodiff::{Tape, Tensors, Value};
use crate::linalg::{Csr, Matrix};
use crate::mesh::TriMesh;
use crate::model::{Network, Vertices, Weights, in_edge_lengths, point_sampler};
use crate::simplify::{edge_graph, vertex_normals};
use std::sync::Arc;

pub(super) struct ScoredMesh {
    pub tape: Tape,
    pub net: Network<Value>,
    /// Adjacency, n x n: the edges of the mesh, or the k-nn graph of a point cloud.
    pub rings: Arc<Csr>,
    /// Positions, n x 3, in units of the mean edge length.
    pub points: Vec<[f32; 3]>,
    /// Unit normals, n x 3; zero if unknown.
    pub normals: Vec<[f32; 3]>,
    pub scores: Value,
}

pub(super) fn score_mesh(weights: &Weights, mesh: &TriMesh) -> ScoredMesh {
    score_points(weights, mesh.positions(), vertex_normals(mesh), edge_graph(mesh))
}

pub(super) fn score_points(
    weights: &Weights,
    positions: &[[f32; 3]],
    normals: Vec<[f32; 3]>,
    rings: Csr,
) -> ScoredMesh {
    let rings = Arc::new(rings);
    let points = in_edge_lengths(positions, &rings);
    let mut tape = Tape::default();
    let net = weights.parameters(&mut tape);
    let (places, directions) = (constant(&points), constant(&normals));
    let vertices = Vertices { points: &places, normals: Some(&directions) };
    let scores = point_sampler(&mut tape, &net.point_sampler, vertices, &rings);
    ScoredMesh { tape, net, rings, points, normals, scores }
}

impl ScoredMesh {
    pub fn backward(&self, gradient: Vec<f32>) -> Tensors<Matrix> {
        let gradient = Matrix::new(gradient.len(), 1, gradient);
        network_gradients(&self.net, &self.tape.backward(&[(&self.scores, gradient)]))
    }
}

pub(super) fn constant(points: &[[f32; 3]]) -> Value {
    Value::constant(Matrix::from_points(points))
}
