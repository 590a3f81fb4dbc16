//! Assignment of each vertex to its nearest sample along the surface.

use crate::linalg::Csr;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Mark of vertices that no sample reaches.
pub const NO_SAMPLE: u32 = u32::MAX;

/// Finds for every vertex the sample that is nearest along the edges of the mesh.
///
/// One search from all samples at once (Dijkstra), O(n log n).
///
/// # Ties
/// Lengths are summed from the sample on, in double precision. An edge is tight if the distance of its start plus its
/// length, rounded, is the distance of its end. A vertex belongs to the first sample from which a path of tight edges
/// leads.
///
/// # Shapes
/// - `positions`: n x 3, `rings`: n x n
/// - `samples`: n_samples different vertices
/// - returns n indices into `samples`, [`NO_SAMPLE`] where the component has none
///
/// # Panics
/// If a sample is no vertex.
///
/// ```
/// # use neural_mesh_simplify as neural_mesh;
/// use neural_mesh::{linalg::Csr, simplify::paper::{NO_SAMPLE, assign_to_samples}};
/// let positions = [[0.0; 3], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0], [4.0, 0.0, 0.0], [9.0, 0.0, 0.0]];
/// let path = Csr::from_edges(5, [[0, 1], [1, 2], [2, 3]]);
/// assert_eq!(assign_to_samples(&positions, &path, &[0, 3]), [0, 0, 1, 1, NO_SAMPLE]);
/// ```
pub fn assign_to_samples(positions: &[[f32; 3]], rings: &Csr, samples: &[u32]) -> Vec<u32> {
    let mut nearest = vec![(f64::INFINITY, NO_SAMPLE); positions.len()];
    let mut is_settled = vec![false; positions.len()];
    let mut queue = BinaryHeap::with_capacity(samples.len());
    for (&vertex, sample) in samples.iter().zip(0..) {
        nearest[vertex as usize] = (0.0, sample);
        queue.push(Reverse((Distance(0.0), sample, vertex)));
    }
    while let Some(Reverse((Distance(distance), sample, vertex))) = queue.pop() {
        if std::mem::replace(&mut is_settled[vertex as usize], true) {
            continue;
        }
        for &neighbour in rings.row(vertex as usize) {
            let reached = (distance + edge_length(positions, vertex, neighbour), sample);
            if reached < nearest[neighbour as usize] {
                nearest[neighbour as usize] = reached;
                queue.push(Reverse((Distance(reached.0), sample, neighbour)));
            }
        }
    }
    nearest.into_iter().map(|(_, sample)| sample).collect()
}

fn edge_length(positions: &[[f32; 3]], a: u32, b: u32) -> f64 {
    let [a, b] = [a, b].map(|v| glam::Vec3::from(positions[v as usize]).as_dvec3());
    a.distance(b)
}

#[derive(Clone, Copy, PartialEq)]
struct Distance(f64);

impl Eq for Distance {}

impl PartialOrd for Distance {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Distance {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Relaxes all edges until nothing changes, first for distances, then for samples along tight edges.
    fn naive(positions: &[[f32; 3]], rings: &Csr, samples: &[u32]) -> Vec<u32> {
        let (mut distances, mut first) = (vec![f64::INFINITY; positions.len()], vec![NO_SAMPLE; positions.len()]);
        for (&vertex, sample) in samples.iter().zip(0..) {
            (distances[vertex as usize], first[vertex as usize]) = (0.0, sample);
        }
        for _ in 0..positions.len() {
            for [a, b] in rings.entries() {
                let reached = distances[a as usize] + edge_length(positions, a, b);
                distances[b as usize] = distances[b as usize].min(reached);
            }
        }
        for _ in 0..positions.len() {
            for [a, b] in rings.entries() {
                let is_tight = distances[a as usize] + edge_length(positions, a, b) == distances[b as usize];
                if is_tight {
                    first[b as usize] = first[b as usize].min(first[a as usize]);
                }
            }
        }
        first
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        #[test]
        fn agrees_with_relaxing_all_edges(
            positions in prop::collection::vec(prop::array::uniform3(-2i8..3), 2..40),
            edges in prop::collection::vec([0u32..40, 0..40], 0..80),
            n_samples in 1usize..5,
        ) {
            let positions: Vec<[f32; 3]> = positions.iter().map(|p| p.map(f32::from)).collect();
            let n = positions.len() as u32;
            let rings = Csr::from_edges(positions.len(), edges.iter().map(|e| e.map(|v| v % n)).collect::<Vec<_>>());
            let samples: Vec<u32> = (0..n).step_by(n_samples).collect();
            prop_assert_eq!(assign_to_samples(&positions, &rings, &samples), naive(&positions, &rings, &samples));
        }
    }

    // Two paths have equal edges in different orders, so their sums differ in the last bit; one edge farther on they
    // round to one number.
    #[test]
    fn a_path_that_is_longer_by_a_rounding_decides_nothing_farther_on() {
        let xy = [[-5, -2], [-2, -1], [-1, 0], [0, 0], [2, 1], [3, 1], [4, 1], [5, 2]];
        let positions = [0, 1, 2, 3, 4, 5, 6, 7].map(|v| [xy[v][0] as f32, xy[v][1] as f32, f32::from(v == 4)]);
        let length = |path: [u32; 4]| path.windows(2).fold(0.0, |sum, e| sum + edge_length(&positions, e[0], e[1]));
        let [first, second] = [[0, 1, 2, 3], [7, 6, 5, 3]].map(length);
        let last = edge_length(&positions, 3, 4);
        assert!(first > second && first + last == second + last);
        let edges = [[0, 1], [1, 2], [2, 3], [3, 4], [3, 5], [5, 6], [6, 7]];
        // Vertices in this order and in the opposite one.
        for renamed in [|v: u32| v, |v: u32| 7 - v] {
            let positions: Vec<[f32; 3]> = (0..8).map(|v| positions[renamed(v) as usize]).collect();
            let (rings, samples) = (Csr::from_edges(8, edges.map(|e| e.map(renamed))), [0, 7].map(renamed));
            let found = assign_to_samples(&positions, &rings, &samples);
            assert_eq!((0..8).map(|v| found[renamed(v) as usize]).collect::<Vec<_>>(), [0, 0, 0, 1, 1, 1, 1, 1]);
            assert_eq!(found, naive(&positions, &rings, &samples));
        }
    }

    #[test]
    fn of_equally_near_samples_the_first_has_the_vertex() {
        let positions = [[-1.0, 0.0, 0.0], [0.0; 3], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
        let path = Csr::from_edges(4, [[0, 1], [1, 2], [2, 3]]);
        assert_eq!(assign_to_samples(&positions, &path, &[0, 2]), [0, 0, 1, 1]);
        assert_eq!(assign_to_samples(&positions, &path, &[2, 0]), [1, 0, 0, 0]);
        // Also a vertex that is a sample itself, where an earlier one has its position and an edge to it.
        assert_eq!(assign_to_samples(&positions, &path, &[2, 3]), [0; 4]);
    }
}
