//! The loss between proposed and classified probabilities.

use super::{Candidates, Proposal};
use neural_mesh::loss::Term;

/// Computes the mean of `(p - q)^2 / 2` over triangles that are candidates (probability p) and proposals (largest q).
///
/// # Shapes
/// - returns the loss and its gradient by q; p is constant
pub fn proposal_match(candidates: &Candidates, proposals: &[Proposal]) -> Term {
    let mut order: Vec<usize> = (0..proposals.len()).collect();
    let before = |a: &Proposal, b: &Proposal| a.triangle.cmp(&b.triangle).then(b.probability.total_cmp(&a.probability));
    order.sort_by(|&a, &b| before(&proposals[a], &proposals[b]));
    order.dedup_by_key(|at| proposals[*at].triangle);
    let place = |at: &usize| candidates.triangles.binary_search(&proposals[*at].triangle).ok();
    let shared: Vec<(usize, f64)> = order
        .iter()
        .filter_map(|at| Some((*at, candidates.probabilities[place(at)?])))
        .map(|(at, p)| (at, f64::from(proposals[at].probability) - f64::from(p)))
        .collect();
    let scale = shared.len() as f64 + LEAST;
    let mut gradient = vec![0.0; proposals.len()];
    shared.iter().for_each(|&(at, difference)| gradient[at] = (difference / scale) as f32);
    Term { value: shared.iter().map(|(_, difference)| difference * difference / 2.0).sum::<f64>() / scale, gradient }
}

// Number added to that of the triangles, which may be 0.
const LEAST: f64 = 1e-3;

#[cfg(test)]
mod tests {
    use super::super::test_golden::{assert_gradient, probabilities, triangles};
    use super::*;

    #[test]
    fn gradients_agree_with_differences() {
        let mut triangles: Vec<[u32; 3]> = triangles();
        triangles.iter_mut().for_each(|triangle| triangle.sort_unstable());
        let proposed = triangles.clone();
        triangles.truncate(5);
        triangles.sort_unstable();
        let candidates = Candidates { triangles, probabilities: vec![0.2, 0.9, 0.4, 0.7, 0.1] };
        assert_gradient(&probabilities(), |q| {
            let proposal = |(&triangle, &probability)| Proposal { triangle, probability, query: 0, row: 0 };
            proposal_match(&candidates, &proposed.iter().zip(q).map(proposal).collect::<Vec<_>>())
        });
    }

    #[test]
    fn the_largest_proposal_of_a_triangle_counts() {
        let candidates = Candidates { triangles: vec![[0, 1, 2]], probabilities: vec![0.75] };
        let proposal = |probability: f32| Proposal { triangle: [0, 1, 2], probability, query: 0, row: 0 };
        let term = proposal_match(&candidates, &[proposal(0.25), proposal(0.5)]);
        assert!((term.value - 0.03125).abs() < 1e-4);
        assert!(term.gradient[0] == 0.0 && (term.gradient[1] + 0.25).abs() < 1e-3);
    }

    #[test]
    fn nothing_shared_costs_nothing() {
        let proposal = Proposal { triangle: [0, 1, 2], probability: 0.5, query: 0, row: 0 };
        assert_eq!(proposal_match(&Candidates::default(), &[proposal]), Term::zero(1));
    }
}
