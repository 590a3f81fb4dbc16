//! Smoothness of the scores over the surface, an addition to the paper.

use super::Term;
use crate::linalg::Csr;

/// Computes the mean of `(s_i - s_j)^2` over the entries (i, j) of a symmetric graph.
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::{linalg::Csr, loss::smoothness};
/// let term = smoothness(&[1.0, 4.0, 4.0], &Csr::from_edges(3, [[0, 1], [1, 2]]));
/// assert_eq!((term.value, term.gradient), (4.5, vec![-3.0, 3.0, 0.0]));
/// ```
pub fn smoothness(scores: &[f32], rings: &Csr) -> Term {
    assert_eq!(scores.len(), rings.n_rows(), "one score per row");
    let mut gradient = vec![0.0f64; scores.len()];
    let mut sum = 0.0;
    for [i, j] in rings.entries().map(|pair| pair.map(|v| v as usize)) {
        let difference = f64::from(scores[i]) - f64::from(scores[j]);
        sum += difference * difference;
        gradient[i] += 2.0 * difference;
        gradient[j] -= 2.0 * difference;
    }
    Term::mean(sum, &gradient, rings.n_entries())
}

#[cfg(test)]
mod tests {
    use super::super::test_gradients::{assert_gradient, uniform};
    use super::*;
    use crate::linalg::test_values::ragged_graph;

    #[test]
    fn agrees_with_differences() {
        let entries: Vec<_> = ragged_graph(20).entries().collect();
        let graph = Csr::from_edges(20, entries);
        assert_gradient(&uniform(20, 1), 1e-4, |scores| smoothness(scores, &graph));
        assert_eq!(smoothness(&[3.0; 20], &graph).value, 0.0);
    }
}
