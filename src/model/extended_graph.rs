//! The extended graph G_ext, Sec. 3.2: the original connectivity of the samples, and their nearest neighbours.

use crate::linalg::Csr;
use crate::spatial::nearest_neighbours;

/// Unites the original connectivity with the k-nn graph, both as undirected edges, so that no sample is isolated.
///
/// A k-nn graph alone misses one in twenty of the triangles that a good triangulation needs; the original
/// connectivity has them.
///
/// # Shapes
/// - `points`: n x 3, the samples
/// - `original`: n x n, which samples the mesh joins
/// - returns n x n, symmetric
///
/// ```
/// use neural_mesh::{linalg::Csr, model::extended_graph};
/// let points = [[0.0; 3], [1.0, 0.0, 0.0], [5.0, 0.0, 0.0]];
/// let graph = extended_graph(&points, &Csr::from_edges(3, [[0, 2]]), 1);
/// assert_eq!(graph, Csr::from_edges(3, [[0, 1], [1, 2], [0, 2]]));
/// ```
pub fn extended_graph(points: &[[f32; 3]], original: &Csr, k: usize) -> Csr {
    let neighbours = nearest_neighbours(points, k);
    let k = neighbours.len() / points.len().max(1);
    let nearest = neighbours.iter().enumerate().map(|(at, &j)| [(at / k) as u32, j]);
    Csr::from_edges(points.len(), nearest.chain(original.entries()))
}
