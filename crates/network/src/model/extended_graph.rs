//! Extended graph G_ext, Sec. 3.2.

use crate::linalg::Csr;
use crate::spatial::nearest_neighbours;

/// Unites the mesh's connectivity of the samples with their k-nearest-neighbour graph; symmetric, n x n.
///
/// # Shapes
/// - `points`: the samples
/// - `original`: n x n, samples joined by the mesh
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::{linalg::Csr, model::extended_graph};
/// let points = [[0.0; 3], [1.0, 0.0, 0.0], [5.0, 0.0, 0.0]];
/// let graph = extended_graph(&points, &Csr::from_edges(3, [[0, 2]]), 1);
/// assert_eq!(graph, Csr::from_edges(3, [[0, 1], [1, 2], [0, 2]]));
/// ```
pub fn extended_graph(points: &[[f32; 3]], original: &Csr, k: usize) -> Csr {
    let neighbours = nearest_neighbours(points, k);
    let k = neighbours.len() / points.len().max(1);
    let nearest = |i: usize| &neighbours[i * k..][..k];
    // The transposed relation: row `j` lists the samples that have `j` among their nearest.
    let all = (0..points.len() as u32).flat_map(|i| nearest(i as usize).iter().map(move |&j| [j, i]));
    let nearest_to = Csr::from_entries(points.len(), points.len(), all);
    Csr::from_rows(points.len(), points.len(), |i, row| {
        [nearest(i), nearest_to.row(i), original.row(i)].into_iter().for_each(|other| row.extend_from_slice(other));
    })
}
