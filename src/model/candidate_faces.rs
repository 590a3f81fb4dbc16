//! Candidate faces and their prior, Sec. 3.2: the triangles of the predicted adjacency.

use crate::autodiff::{Tape, Value};
use crate::linalg::Csr;
use crate::spatial::coherent_order;
use rayon::prelude::*;
use std::sync::Arc;

/// Triangles that the Face Classifier judges, in any order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CandidateFaces {
    /// n_candidates x 3 samples, each triangle ascending.
    pub triangles: Vec<[u32; 3]>,
    /// Where the edges ij, ik, jk of each triangle stand among the entries of G_ext, n_candidates x 3.
    pub entries: Arc<[[u32; 3]]>,
}

impl CandidateFaces {
    /// The same candidates, near ones near each other: the classifier visits the neighbours of each, and there are
    /// many.
    ///
    /// # Panics
    /// When a corner is none of `points`.
    pub fn in_coherent_order(&self, points: &[[f32; 3]]) -> Self {
        let order = coherent_order(&barycenters(points, &self.triangles));
        Self {
            triangles: order.iter().map(|&at| self.triangles[at as usize]).collect(),
            entries: order.iter().map(|&at| self.entries[at as usize]).collect(),
        }
    }
}

/// The barycenter of each triangle, n_triangles x 3.
///
/// # Panics
/// When a corner is none of `points`.
///
/// ```
/// use neural_mesh::model::barycenters;
/// assert_eq!(barycenters(&[[0.0; 3], [3.0, 0.0, 0.0], [0.0, 6.0, 0.0]], &[[0, 1, 2]]), [[1.0, 2.0, 0.0]]);
/// ```
pub fn barycenters(points: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<[f32; 3]> {
    let barycenter = |corners: &[u32; 3]| {
        let [i, j, k] = corners.map(|v| points[v as usize]);
        [0, 1, 2].map(|axis| (i[axis] + j[axis] + k[axis]) / 3.0)
    };
    triangles.iter().map(barycenter).collect()
}

/// Finds the triangles whose three edges have a positive A_s, and always those of the original surface; in
/// lexicographic order.
///
/// # Shapes
/// - `graph`: n x n, the extended graph, symmetric
/// - `adjacency`: A_s, one value per entry of `graph`
/// - `original`: n_original x 3, triangles that the mesh spans between regions, each ascending, the list sorted, their
///   edges in `graph`
///
/// ```
/// use neural_mesh::{linalg::Csr, model::candidate_faces};
/// let graph = Csr::from_edges(4, [[0, 1], [1, 2], [0, 2], [2, 3], [0, 3]]);
/// let all = candidate_faces(&graph, &[1.0; 10], &[]);
/// assert_eq!(all.triangles, [[0, 1, 2], [0, 2, 3]]);
/// let only_the_original = candidate_faces(&graph, &[0.0; 10], &[[0, 2, 3]]);
/// assert_eq!(only_the_original.triangles, [[0, 2, 3]]);
/// ```
pub fn candidate_faces(graph: &Csr, adjacency: &[f32], original: &[[u32; 3]]) -> CandidateFaces {
    let is_positive = |at: usize| adjacency[at] > 0.0;
    let of_row = |i: usize| {
        let mut found = Vec::new();
        for (ij, &j) in later(graph, i) {
            for (ik, jk, k) in common(graph, i, j) {
                let triangle = [i as u32, j, k];
                let is_predicted = is_positive(ij) && is_positive(ik) && is_positive(jk);
                if is_predicted || original.binary_search(&triangle).is_ok() {
                    found.push((triangle, [ij, ik, jk].map(|at| at as u32)));
                }
            }
        }
        found
    };
    let (triangles, entries): (Vec<_>, Vec<_>) = (0..graph.n_rows()).into_par_iter().flat_map_iter(of_row).unzip();
    CandidateFaces { triangles, entries: entries.into() }
}

/// Entries of row `i` right of the diagonal, with their places.
fn later(graph: &Csr, i: usize) -> impl Iterator<Item = (usize, &u32)> {
    let row = graph.row(i);
    let skipped = row.partition_point(|&j| j as usize <= i);
    (graph.range(i).start + skipped..).zip(&row[skipped..])
}

/// Nodes after `j` that both `i` and `j` are joined to, with the places of ik and jk.
fn common(graph: &Csr, i: usize, j: u32) -> impl Iterator<Item = (usize, usize, u32)> {
    let mut of_j = later(graph, j as usize).peekable();
    later(graph, i).filter_map(move |(ik, &k)| {
        while of_j.next_if(|(_, of_j)| **of_j < k).is_some() {}
        of_j.next_if(|(_, of_j)| **of_j == k).map(|(jk, _)| (ik, jk, k))
    })
}

/// Computes `p_init = (A_s[i, j] + A_s[i, k] + A_s[j, k]) / 3`, the classifier's first feature.
///
/// # Shapes
/// - `adjacency`: n_entries x 1
/// - returns n_candidates x 1
///
/// ```
/// use neural_mesh::{autodiff::{Tape, Value}, linalg::{Csr, Matrix}, model::{candidate_faces, prior}};
/// let triangle = Csr::from_edges(3, [[0, 1], [1, 2], [0, 2]]);
/// let adjacency = [0.25, 0.5, 0.25, 0.75, 0.5, 0.75];
/// let candidates = candidate_faces(&triangle, &adjacency, &[]);
/// let adjacency = Value::constant(Matrix::new(6, 1, adjacency.to_vec()));
/// assert_eq!(prior(&mut Tape::default(), &adjacency, &candidates).matrix().data(), [0.5]);
/// ```
pub fn prior(tape: &mut Tape, adjacency: &Value, candidates: &CandidateFaces) -> Value {
    tape.mean_of_three(adjacency, &candidates.entries)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::Matrix;
    use crate::linalg::test_values::{ragged_graph, random};

    #[test]
    fn agrees_with_trying_all_triples() {
        let entries: Vec<_> = ragged_graph(30).entries().collect();
        let graph = Csr::from_edges(30, entries);
        let adjacency = random(graph.n_entries(), 1, 4).into_data();
        let value = |i: u32, j: u32| graph.position(i as usize, j).map(|at| adjacency[at]);
        let mut expected = Vec::new();
        for i in 0..30 {
            for j in i + 1..30 {
                for k in j + 1..30 {
                    if [value(i, j), value(i, k), value(j, k)].iter().all(|v| v.is_some_and(|v| v > 0.0)) {
                        expected.push([i, j, k]);
                    }
                }
            }
        }
        assert!(!expected.is_empty());
        assert_eq!(candidate_faces(&graph, &adjacency, &[]).triangles, expected);
    }

    #[test]
    fn prior_is_the_mean_of_the_three_edges() {
        let graph = Csr::from_edges(3, [[0, 1], [1, 2], [0, 2]]);
        let adjacency = [0.3, 0.6, 0.3, 0.9, 0.6, 0.9];
        let candidates = candidate_faces(&graph, &adjacency, &[]);
        let adjacency = Value::constant(Matrix::new(6, 1, adjacency.to_vec()));
        let prior = prior(&mut Tape::default(), &adjacency, &candidates);
        assert!((prior.matrix().data()[0] - 0.6).abs() < 1e-6);
    }
}
