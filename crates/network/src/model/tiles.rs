//! Graph layers computed tile by tile, so that the features of one tile are in memory and not those of all nodes.

use crate::linalg::Csr;
use std::sync::Arc;

/// Number of nodes in a tile: their features take 8 MB in a layer 32 wide, and few more nodes surround a tile.
pub(super) const TILE: usize = 1 << 16;
/// Marks nodes outside the tile and its surroundings.
const ABSENT: u32 = u32::MAX;

/// Computes a value per node of a graph, in tiles of `n_tile` nodes that follow each other in `order`.
///
/// `compute` sees the nodes of a tile and all that `n_hops` edges reach from them, ascending, with the graph between
/// these, and returns a value for each. The tile's own values are exact if `compute` applies at most `n_hops` layers
/// over direct neighbours.
///
/// # Shapes
/// - `graph`: n x n; `order`: n nodes, each once, near ones near each other
/// - returns n values
pub(super) fn compute_in_tiles(
    graph: &Arc<Csr>,
    order: impl FnOnce() -> Vec<u32>,
    (n_tile, n_hops): (usize, usize),
    compute: impl Fn(&[u32], &Arc<Csr>) -> Vec<f32>,
) -> Vec<f32> {
    let n = graph.n_rows();
    if n <= n_tile {
        return compute(&(0..n as u32).collect::<Vec<_>>(), graph);
    }
    let (mut values, mut local) = (vec![0.0; n], vec![ABSENT; n]);
    for tile in order().chunks(n_tile) {
        let nodes = surroundings(graph, tile, n_hops, &mut local);
        let columns = |row: usize, columns: &mut Vec<u32>| {
            let inside = graph.row(nodes[row] as usize).iter().map(|&node| local[node as usize]);
            columns.extend(inside.filter(|&node| node != ABSENT));
        };
        let of_nodes = compute(&nodes, &Csr::from_rows(nodes.len(), nodes.len(), columns).into());
        tile.iter().for_each(|&node| values[node as usize] = of_nodes[local[node as usize] as usize]);
        nodes.iter().for_each(|&node| local[node as usize] = ABSENT);
    }
    values
}

/// Returns a tile and the nodes that `n_hops` edges reach from it, ascending; writes the index of each into `local`.
fn surroundings(graph: &Csr, tile: &[u32], n_hops: usize, local: &mut [u32]) -> Vec<u32> {
    let mut nodes = tile.to_vec();
    nodes.iter().for_each(|&node| local[node as usize] = 0);
    let mut n_visited = 0;
    for _ in 0..n_hops {
        let ring = n_visited..nodes.len();
        n_visited = nodes.len();
        for at in ring {
            for &node in graph.row(nodes[at] as usize) {
                if local[node as usize] == ABSENT {
                    local[node as usize] = 0;
                    nodes.push(node);
                }
            }
        }
    }
    // Nodes keep their order in the whole graph, so that sums over neighbours add in the same order.
    nodes.sort_unstable();
    (0..).zip(&nodes).for_each(|(at, &node)| local[node as usize] = at);
    nodes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::test_values::{ragged_graph, random};

    /// Adds the values of all neighbours to a node's, `n_hops` times.
    fn sums(graph: &Csr, start: &[f32], n_hops: usize) -> Vec<f32> {
        (0..n_hops).fold(start.to_vec(), |values, _| {
            let sum =
                |row: usize| graph.row(row).iter().fold(values[row], |sum, &node| 0.5 * sum + values[node as usize]);
            (0..graph.n_rows()).map(sum).collect()
        })
    }

    #[test]
    fn tiles_give_the_bits_of_the_whole() {
        let (graph, start) = (Arc::new(ragged_graph(60)), random(60, 1, 3).into_data());
        let reversed = || (0..60).rev().collect::<Vec<u32>>();
        for n_hops in [1, 3] {
            let compute = |nodes: &[u32], graph: &Arc<Csr>| {
                let start: Vec<f32> = nodes.iter().map(|&node| start[node as usize]).collect();
                sums(graph, &start, n_hops)
            };
            for n_tile in [1, 7, 59, 60] {
                let values = compute_in_tiles(&graph, reversed, (n_tile, n_hops), compute);
                assert_eq!(values, sums(&graph, &start, n_hops), "{n_tile} {n_hops}");
            }
        }
    }
}
