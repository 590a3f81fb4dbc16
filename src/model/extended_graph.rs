//! Extended graph G_ext, Sec. 3.2: the original connectivity of the samples and their nearest neighbours.

use crate::linalg::Csr;
use crate::spatial::nearest_neighbours;

/// Unites the original connectivity with the k-nn graph, both undirected, so that no sample is isolated.
///
/// The k-nn graph alone misses one in twenty triangles of a good triangulation.
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
    let nearest = |i: usize| &neighbours[i * k..][..k];
    // Who has whom among its nearest, the other way round.
    let all = (0..points.len() as u32).flat_map(|i| nearest(i as usize).iter().map(move |&j| [j, i]));
    let nearest_to = Csr::from_entries(points.len(), points.len(), all);
    Csr::from_rows(points.len(), points.len(), |i, row| {
        [nearest(i), nearest_to.row(i), original.row(i)].into_iter().for_each(|other| row.extend_from_slice(other));
    })
}
