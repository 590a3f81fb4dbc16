//! Scores of a mesh's vertices from the network's Point Sampler, Sec. 3.1.

use crate::linalg::Csr;
use crate::mesh::TriMesh;
use crate::model::{Weights, in_edge_lengths, vertex_scores};
use std::sync::Arc;

/// Scores every vertex of a mesh; larger ones are to be sampled sooner, and only differences matter.
///
/// ```
/// use neural_mesh::{mesh::TriMesh, model::Weights, simplify::network_scores};
/// let mesh = TriMesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]).unwrap();
/// assert_eq!(network_scores(&mesh, &Weights::random(1)).len(), 3);
/// ```
pub fn network_scores(mesh: &TriMesh, weights: &Weights) -> Vec<f32> {
    let rings = Arc::new(edge_graph(mesh));
    vertex_scores(weights, &in_edge_lengths(mesh.positions(), &rings), &rings)
}

/// The edges of a mesh as a graph, n_vertices x n_vertices, what the Point Sampler convolves over.
///
/// ```
/// use neural_mesh::{mesh::shapes::tetrahedron, simplify::edge_graph};
/// assert_eq!(edge_graph(&tetrahedron()).row(0), [1, 2, 3]);
/// ```
pub fn edge_graph(mesh: &TriMesh) -> Csr {
    let edges = mesh.faces().iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    Csr::from_edges(mesh.positions().len(), edges)
}
