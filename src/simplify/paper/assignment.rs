//! The assignment: each vertex belongs to its nearest sample along the surface.

use crate::linalg::Csr;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Marks vertices that no sample can be reached from.
pub const NO_SAMPLE: u32 = u32::MAX;

/// Finds for every vertex the sample that is nearest along the edges of the mesh, of equally near ones the first.
///
/// One search from all samples at once (Dijkstra), O(n log n).
///
/// # Shapes
/// - `positions`: n x 3, `rings`: n x n
/// - `samples`: n_samples different vertices
/// - returns n indices into `samples`, [`NO_SAMPLE`] where the component has none
///
/// # Panics
/// When a sample is no vertex.
///
/// ```
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
    let [a, b] = [a, b].map(|v| glam::DVec3::from(positions[v as usize].map(f64::from)));
    a.distance(b)
}

/// A distance with the order of its number.
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

    /// Shortest ways from each sample by relaxing all edges until nothing changes.
    fn naive(positions: &[[f32; 3]], rings: &Csr, samples: &[u32]) -> Vec<u32> {
        let mut nearest = vec![(f64::INFINITY, NO_SAMPLE); positions.len()];
        samples.iter().zip(0..).for_each(|(&vertex, sample)| nearest[vertex as usize] = (0.0, sample));
        for _ in 0..positions.len() {
            for [a, b] in rings.entries() {
                let (distance, sample) = nearest[a as usize];
                let reached = (distance + edge_length(positions, a, b), sample);
                if reached < nearest[b as usize] {
                    nearest[b as usize] = reached;
                }
            }
        }
        nearest.into_iter().map(|(_, sample)| sample).collect()
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
}
