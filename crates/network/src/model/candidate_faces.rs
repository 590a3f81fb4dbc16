//! Candidate faces, Sec. 3.2.

use crate::autodiff::{Tape, Value};
use crate::linalg::{Csr, Rows};
use crate::parallel;
use crate::spatial::coherent_order;
use std::sync::Arc;

/// The triangles judged by the Face Classifier.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CandidateFaces {
    /// n_candidates x 3 samples, each triangle ascending.
    pub triangles: Vec<[u32; 3]>,
    /// Indices of the edges ij, ik, jk of each triangle among the entries of G_ext.
    pub entries: Arc<[[u32; 3]]>,
}

impl CandidateFaces {
    /// Keeps the `n` candidates of largest prior, and all that are in `original`.
    ///
    /// # Shapes
    /// - `adjacency`: A_s, one value per entry of G_ext
    /// - `original`: as for [`candidate_faces`]
    ///
    /// ```
    /// # use neural_mesh_network as neural_mesh;
    /// use neural_mesh::{linalg::Csr, model::candidate_faces};
    /// let graph = Csr::from_edges(5, [[0, 1], [0, 2], [1, 2], [0, 3], [1, 3], [0, 4], [1, 4]]);
    /// let adjacency: Vec<f32> = graph.entries().map(|[i, j]| if i == 3 || j == 3 { 0.9 } else { 0.1 }).collect();
    /// let all = candidate_faces(&graph, &adjacency, &[]);
    /// assert_eq!(all.with_largest_prior(1, &adjacency, &[[0, 1, 4]]).triangles, [[0, 1, 3], [0, 1, 4]]);
    /// ```
    pub fn with_largest_prior(self, n: usize, adjacency: &[f32], original: &[[u32; 3]]) -> Self {
        if n >= self.triangles.len() {
            return self;
        }
        let prior = |at: usize| self.entries[at].iter().map(|&at| adjacency[at as usize]).sum::<f32>();
        let priors = parallel::map(self.entries.len(), 1024, prior);
        let mut descending = priors.clone();
        let least = *descending.select_nth_unstable_by(n, |a, b| b.total_cmp(a)).1;
        // `least` is the prior of the first candidate left out. Candidates of exactly this prior fill the remaining places
        // in order.
        let mut n_equal = n - priors.iter().filter(|&&prior| prior > least).count();
        let mut kept = Vec::with_capacity(n + original.len());
        let mut spanned = original.iter().peekable();
        for (at, (&prior, triangle)) in priors.iter().zip(&self.triangles).enumerate() {
            // Both lists are sorted: one walk along both finds the triangles of the surface.
            while spanned.next_if(|spanned| *spanned < triangle).is_some() {}
            let is_spanned = spanned.next_if_eq(&triangle).is_some();
            let is_equal = prior == least && n_equal > 0;
            n_equal -= usize::from(is_equal);
            if prior > least || is_equal || is_spanned {
                kept.push(at);
            }
        }
        self.select(kept.into_iter())
    }

    /// Joins every candidate with those that share an edge with it: G_tri.
    ///
    /// # Shapes
    /// - `n_entries`: number of entries of G_ext
    ///
    /// ```
    /// # use neural_mesh_network as neural_mesh;
    /// use neural_mesh::{linalg::Csr, model::candidate_faces};
    /// let graph = Csr::from_edges(5, [[0, 1], [1, 2], [0, 2], [2, 3], [0, 3], [3, 4], [2, 4]]);
    /// let strip = candidate_faces(&graph, &[1.0; 14], &[]);
    /// assert_eq!(strip.across_edges(14), Csr::from_edges(3, [[0, 1], [1, 2]]));
    /// ```
    pub fn across_edges(&self, n_entries: usize) -> Csr {
        join_across_edges(&self.entries, n_entries)
    }

    fn select(&self, at: impl Iterator<Item = usize> + Clone) -> Self {
        Self {
            triangles: at.clone().map(|at| self.triangles[at]).collect(),
            entries: at.map(|at| self.entries[at]).collect(),
        }
    }

    /// Sorts the candidates of [`candidate_faces`] so that near ones are near each other in memory.
    pub fn in_coherent_order(&self, points: &[[f32; 3]]) -> Self {
        // Candidates in lexicographic order are grouped by first corner. The groups are sorted, not the single candidates.
        let of_corners = Rows::new(points.len(), self.triangles.iter().map(|triangle| triangle[0]).zip(0..));
        let order = coherent_order(points);
        self.select(order.iter().flat_map(|&corner| of_corners.row(corner as usize)).map(|&at: &u32| at as usize))
    }
}

/// Joins triangles that share an edge, by the number of each of their edges.
///
/// # Shapes
/// - `edges`: n_triangles x 3, below `n_edges`
/// - returns n_triangles x n_triangles, symmetric, without loops
pub(super) fn join_across_edges(edges: &[[u32; 3]], n_edges: usize) -> Csr {
    let at_edges = Rows::new(n_edges, edges.iter().zip(0u32..).flat_map(|(edges, at)| edges.map(|edge| (edge, at))));
    Csr::from_rows(edges.len(), edges.len(), |at, neighbours| {
        let others = edges[at].into_iter().flat_map(|edge| at_edges.row(edge as usize));
        neighbours.extend(others.filter(|&&other| other != at as u32));
    })
}

/// Returns the barycenter of each triangle.
///
/// ```
/// # use neural_mesh_network as neural_mesh;
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

/// Finds the triangles whose three edges have positive A_s, and adds the original's; in lexicographic order.
///
/// # Shapes
/// - `graph`: G_ext, symmetric
/// - `adjacency`: A_s, one value per entry of `graph`
/// - `original`: triangles that the mesh spans between regions, sorted, each ascending, with edges in `graph`
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::{linalg::Csr, model::candidate_faces};
/// let graph = Csr::from_edges(4, [[0, 1], [1, 2], [0, 2], [2, 3], [0, 3]]);
/// let all = candidate_faces(&graph, &[1.0; 10], &[]);
/// assert_eq!(all.triangles, [[0, 1, 2], [0, 2, 3]]);
/// let only_the_original = candidate_faces(&graph, &[0.0; 10], &[[0, 2, 3]]);
/// assert_eq!(only_the_original.triangles, [[0, 2, 3]]);
/// ```
pub fn candidate_faces(graph: &Csr, adjacency: &[f32], original: &[[u32; 3]]) -> CandidateFaces {
    let of_rows = |start: usize| {
        let mut found = Vec::new();
        let rows = start as u32..graph.n_rows().min(start + ROWS) as u32;
        rows.for_each(|row| add_candidates(graph, adjacency, original, row, &mut found));
        found.shrink_to_fit();
        found
    };
    let found = parallel::each((0..graph.n_rows()).step_by(ROWS), of_rows);
    let n = found.iter().map(Vec::len).sum();
    let (mut triangles, mut entries) = (Vec::with_capacity(n), Vec::with_capacity(n));
    // Each task's list is freed once it is read: there are many candidates before the cut.
    for (triangle, of_edges) in found.into_iter().flatten() {
        triangles.push(triangle);
        entries.push(of_edges);
    }
    CandidateFaces { triangles, entries: entries.into() }
}

const ROWS: usize = 256;

/// Adds the candidates whose first corner is `i`.
fn add_candidates(
    graph: &Csr,
    adjacency: &[f32],
    original: &[[u32; 3]],
    i: u32,
    found: &mut Vec<([u32; 3], [u32; 3])>,
) {
    let from = original.partition_point(|triangle| triangle[0] < i);
    let to = from + original[from..].partition_point(|triangle| triangle[0] == i);
    let spanned = &original[from..to];
    let (of_i, start_i) = columns_after(graph, i);
    for (n, &j) in of_i.iter().enumerate() {
        let (of_j, start_j) = columns_after(graph, j);
        let is_joined = adjacency[start_i + n] > 0.0;
        // Both rows ascend: one walk along both finds their common neighbours.
        let mut at = 0;
        for (m, &k) in of_i.iter().enumerate().skip(n + 1) {
            while at < of_j.len() && of_j[at] < k {
                at += 1;
            }
            if at == of_j.len() {
                break;
            }
            if of_j[at] == k {
                let [ij, ik, jk] = [start_i + n, start_i + m, start_j + at];
                let is_predicted = is_joined && adjacency[ik] > 0.0 && adjacency[jk] > 0.0;
                if is_predicted || spanned.binary_search(&[i, j, k]).is_ok() {
                    found.push(([i, j, k], [ij, ik, jk].map(|at| at as u32)));
                }
            }
        }
    }
}

/// Returns the entries of row `i` right of the diagonal, and the index of the first.
fn columns_after(graph: &Csr, i: u32) -> (&[u32], usize) {
    let row = graph.row(i as usize);
    let skipped = row.partition_point(|&j| j <= i);
    (&row[skipped..], graph.range(i as usize).start + skipped)
}

/// Computes `p_init = (A_s[i, j] + A_s[i, k] + A_s[j, k]) / 3`, the classifier's first feature.
///
/// # Shapes
/// - `adjacency`: n_entries x 1
/// - returns n_candidates x 1
///
/// ```
/// # use neural_mesh_network as neural_mesh;
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
    use crate::model::triangle_graph;

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

    fn dense_graph() -> Csr {
        Csr::from_edges(30, (0..30).flat_map(|i| [1, 2, 5, 6].map(|step| [i, (i + step) % 30])))
    }

    #[test]
    fn neighbours_across_edges_agree_with_a_search_by_corners() {
        let graph = dense_graph();
        let candidates = candidate_faces(&graph, &vec![1.0; graph.n_entries()], &[]);
        assert!(candidates.triangles.len() > 30);
        let triangles = &candidates.triangles;
        let share_an_edge = |a: u32, b: u32| {
            let [a, b] = [a, b].map(|at| triangles[at as usize]);
            a.iter().filter(|corner| b.contains(corner)).count() == 2
        };
        let n = triangles.len() as u32;
        let pairs: Vec<[u32; 2]> = (0..n).flat_map(|a| (0..a).map(move |b| [a, b])).collect();
        let expected = Csr::from_edges(triangles.len(), pairs.iter().copied().filter(|&[a, b]| share_an_edge(a, b)));
        assert_eq!(candidates.across_edges(graph.n_entries()), expected);
        assert_eq!(triangle_graph(&[[0.0; 3]; 30], triangles, 0), expected);
    }

    #[test]
    fn the_largest_priors_are_those_of_a_sorted_list() {
        let graph = dense_graph();
        // Few different values, so that many candidates are equal.
        let adjacency: Vec<f32> =
            random(graph.n_entries(), 1, 4).data().iter().map(|x| (4.0 * x).round() + 8.0).collect();
        let all = candidate_faces(&graph, &adjacency, &[]);
        let original = [all.triangles[0], all.triangles[9]];
        let prior = |at: usize| all.entries[at].iter().map(|&entry| adjacency[entry as usize]).sum::<f32>();
        let mut order: Vec<usize> = (0..all.triangles.len()).collect();
        order.sort_by(|&a, &b| prior(b).total_cmp(&prior(a)).then(a.cmp(&b)));
        for n in [0, 1, 10, 25, order.len(), order.len() + 1] {
            let mut kept = order[..n.min(order.len())].to_vec();
            kept.extend([0, 9]);
            kept.sort_unstable();
            kept.dedup();
            let expected: Vec<[u32; 3]> = kept.into_iter().map(|at| all.triangles[at]).collect();
            assert_eq!(all.clone().with_largest_prior(n, &adjacency, &original).triangles, expected, "{n}");
        }
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
