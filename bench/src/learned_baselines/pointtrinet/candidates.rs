//! Candidate triangles and their probabilities.

use neural_mesh::spatial::nearest_neighbours;

// Number of candidates kept after a round, per vertex.
const PER_VERTEX: usize = 12;

/// Distinct candidates, sorted, with ascending corners.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Candidates {
    /// Corners, n x 3.
    pub triangles: Vec<[u32; 3]>,
    /// Probabilities, n.
    pub probabilities: Vec<f32>,
}

impl Candidates {
    /// Returns the first candidates: each vertex with its two nearest.
    pub fn seeds(vertices: &[[f32; 3]]) -> Self {
        if vertices.len() < 3 {
            return Self::default();
        }
        let near = nearest_neighbours(vertices, 2);
        let seed = |(v, pair): (u32, &[u32; 2])| {
            let mut corners = [v, pair[0], pair[1]];
            corners.sort_unstable();
            (corners, 0.5)
        };
        Self::from_pairs((0..).zip(near.as_chunks().0).map(seed).collect())
    }

    /// Adds candidates and keeps the `12 n_vertices` most likely ones.
    pub fn add(&self, new: impl IntoIterator<Item = ([u32; 3], f32)>, n_vertices: usize) -> Self {
        let own = self.triangles.iter().copied().zip(self.probabilities.iter().copied());
        let all = Self::from_pairs(own.chain(new).collect());
        let n_kept = PER_VERTEX * n_vertices;
        if all.triangles.len() <= n_kept {
            return all;
        }
        let mut order: Vec<usize> = (0..all.triangles.len()).collect();
        order.sort_unstable_by(|&a, &b| all.probabilities[b].total_cmp(&all.probabilities[a]).then(a.cmp(&b)));
        order.truncate(n_kept);
        order.sort_unstable();
        Self {
            triangles: order.iter().map(|&at| all.triangles[at]).collect(),
            probabilities: order.iter().map(|&at| all.probabilities[at]).collect(),
        }
    }

    fn from_pairs(mut all: Vec<([u32; 3], f32)>) -> Self {
        all.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
        all.dedup_by_key(|(triangle, _)| *triangle);
        let (triangles, probabilities) = all.into_iter().unzip();
        Self { triangles, probabilities }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_most_likely_stay_each_once() {
        let triangle = |i: u32| [0, 1, 2 + i];
        let mut candidates = Candidates { triangles: vec![triangle(0), triangle(5)], probabilities: vec![0.5, 0.1] };
        let new = |i: u32, probability: f32| (triangle(i), probability);
        candidates = candidates.add([new(5, 0.3), new(0, 0.2), new(7, 0.9)], 1);
        assert_eq!(candidates.triangles, [triangle(0), triangle(5), triangle(7)]);
        assert_eq!(candidates.probabilities, [0.5, 0.3, 0.9]);
        let kept = candidates.add((10..30).map(|i| new(i, 0.6)), 1);
        assert_eq!(kept.triangles.len(), 12);
        assert_eq!(kept.triangles[..2], [triangle(7), triangle(10)]);
    }

    #[test]
    fn seeds_are_vertices_with_their_two_nearest() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [5.0, 0.0, 0.0]];
        assert_eq!(Candidates::seeds(&points).triangles, [[0, 1, 2], [0, 1, 3]]);
        assert_eq!(Candidates::seeds(&[[0.0; 3], [1.0; 3]]), Candidates::default());
        assert_eq!(Candidates::seeds(&[[0.0; 3]; 3]).triangles, [[0, 1, 2]]);
    }
}
