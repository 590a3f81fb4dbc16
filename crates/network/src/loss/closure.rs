//! Edges with a wrong number of faces, an addition to Eq. (10).

use super::Term;
use crate::linalg::Csr;
use rayon::prelude::*;

/// Computes the expected share of edges with a wrong number of faces, if each face is kept independently.
///
/// `P(one) + P(more than two)` per inner edge, `P(more than one)` per boundary edge, exact (Poisson binomial).
///
/// # Shapes
/// - `edges_of_faces`: three edges of each candidate
/// - `at_boundary`: n_edges, true for edges that should have one face
/// - `probabilities`: n_triangles
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::loss::closure;
/// // Two faces over edge 0; the outer edges 1 to 4 are boundaries.
/// let at_boundary = [false, true, true, true, true];
/// let term = closure(&[[0, 1, 2], [0, 3, 4]], &at_boundary, &[0.5, 1.0]);
/// assert_eq!((term.value, term.gradient), (0.5 / 5.0, vec![-0.2, 0.0]));
/// ```
pub fn closure(edges_of_faces: &[[u32; 3]], at_boundary: &[bool], probabilities: &[f32]) -> Term {
    let entries = edges_of_faces.iter().zip(0..).flat_map(|(edges, face)| edges.map(|edge| [edge, face]));
    let faces = Csr::from_entries(at_boundary.len(), edges_of_faces.len(), entries);
    let edge_cost = |edge: usize| {
        let kept: Vec<f64> = faces.row(edge).iter().map(|&t| f64::from(probabilities[t as usize])).collect();
        wrong_number(&kept, at_boundary[edge])
    };
    let used: Vec<usize> = (0..faces.n_rows()).filter(|&edge| !faces.row(edge).is_empty()).collect();
    let each: Vec<(f64, Vec<f64>)> = used.par_iter().map(|&edge| edge_cost(edge)).collect();
    let mut gradient = vec![0.0f64; probabilities.len()];
    for (&edge, (_, slopes)) in used.iter().zip(&each) {
        faces.row(edge).iter().zip(slopes).for_each(|(&t, slope)| gradient[t as usize] += slope);
    }
    Term::mean(each.iter().map(|(value, _)| value).sum(), &gradient, used.len())
}

type CountProbabilities = [f64; 3];

/// Returns the probability that an edge has a wrong number of faces, and its derivative to each p.
fn wrong_number(p: &[f64], at_boundary: bool) -> (f64, Vec<f64>) {
    // The distributions of the number of kept faces before and after face i give the derivative by its probability
    // without a division.
    let mut before = vec![[1.0, 0.0, 0.0]];
    before.extend(p.iter().scan([1.0, 0.0, 0.0], |counts, &p| {
        *counts = add_face(*counts, p);
        Some(*counts)
    }));
    let [none, one, two] = before[p.len()];
    let more_than_two = (1.0 - none - one - two).max(0.0);
    let value = if at_boundary { two + more_than_two } else { one + more_than_two };
    let mut slopes = vec![0.0; p.len()];
    let mut after: CountProbabilities = [1.0, 0.0, 0.0];
    for (i, &p) in p.iter().enumerate().rev() {
        let [none, one, two] = combine_counts(before[i], after);
        // Keeping face i turns zero kept faces into one, and two into too many.
        slopes[i] = if at_boundary { one } else { none - one + two };
        after = add_face(after, p);
    }
    (value, slopes)
}

fn add_face([none, one, two]: CountProbabilities, p: f64) -> CountProbabilities {
    let q = 1.0 - p;
    [none * q, one * q + none * p, two * q + one * p]
}

fn combine_counts(a: CountProbabilities, b: CountProbabilities) -> CountProbabilities {
    [a[0] * b[0], a[0] * b[1] + a[1] * b[0], a[0] * b[2] + a[1] * b[1] + a[2] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::super::test_gradients::{assert_gradient, uniform};
    use super::*;

    fn cost_by_subsets(edges_of_faces: &[[u32; 3]], at_boundary: &[bool], p: &[f32]) -> f64 {
        let n = p.len();
        let count = |kept: u32, edge: usize| {
            (0..n).filter(|&t| kept >> t & 1 == 1 && edges_of_faces[t].contains(&(edge as u32))).count()
        };
        let is_wrong = |kept: u32, edge: usize| match at_boundary[edge] {
            true => count(kept, edge) > 1,
            false => !matches!(count(kept, edge), 0 | 2),
        };
        let wrong = |kept: u32| (0..at_boundary.len()).filter(|&edge| is_wrong(kept, edge)).count() as f64;
        let chance = |kept: u32| (0..n).map(move |t| f64::from(if kept >> t & 1 == 1 { p[t] } else { 1.0 - p[t] }));
        let n_used = (0..at_boundary.len()).filter(|&edge| count(u32::MAX, edge) > 0).count() as f64;
        (0..1 << n).map(|kept| chance(kept).product::<f64>() * wrong(kept)).sum::<f64>() / n_used
    }

    const FACES: [[u32; 3]; 7] = [[0, 1, 2], [0, 3, 4], [0, 5, 6], [0, 1, 3], [2, 4, 5], [6, 1, 2], [0, 2, 4]];
    const BOUNDARY: [bool; 8] = [false, true, false, false, true, false, false, false];

    #[test]
    fn agrees_with_all_subsets_and_with_differences() {
        let p = uniform(7, 1);
        let found = closure(&FACES, &BOUNDARY, &p).value;
        assert!((found - cost_by_subsets(&FACES, &BOUNDARY, &p)).abs() < 1e-6, "{found}");
        assert_gradient(&p, 1e-4, |p| closure(&FACES, &BOUNDARY, p));
    }

    #[test]
    fn a_closed_surface_and_nothing_cost_nothing_and_a_hole_costs_its_edges() {
        let tetrahedron = [[0, 1, 2], [0, 3, 4], [1, 3, 5], [2, 4, 5]];
        let loss = |p: [f32; 4]| closure(&tetrahedron, &[false; 6], &p);
        assert_eq!(loss([1.0; 4]).value, 0.0);
        assert_eq!(loss([0.0; 4]).value, 0.0);
        assert_eq!(loss([1.0, 1.0, 1.0, 0.0]).value, 0.5);
        assert!(loss([1.0, 1.0, 1.0, 0.5]).gradient[3] < 0.0, "the hole wants its face");
        assert!(loss([0.0, 0.0, 0.0, 0.5]).gradient[3] > 0.0, "a lone face has open edges");
    }

    #[test]
    fn nothing_is_fine() {
        assert_eq!(closure(&[], &[], &[]), Term::zero(0));
        assert_eq!(closure(&[], &[false; 3], &[]), Term::zero(0));
    }
}
