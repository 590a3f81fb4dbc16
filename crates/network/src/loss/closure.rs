//! Edges with a wrong number of faces, an addition to Eq. (10).

use super::Term;
use crate::linalg::Csr;
use crate::parallel;

/// Computes the expected number of edges with a wrong number of faces over that of edges with a face.
///
/// Each face is kept independently; the quotient estimates the paper's WA. Wrong are one face or more than two on an
/// inner edge, more than one on a boundary edge; exact (Poisson binomial). As probabilities shrink to 0 the quotient grows
/// to 1, so the empty mesh is no minimum.
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
/// assert_eq!(term.value, 0.5 / 4.0);
/// assert_eq!(term.gradient, [-0.3125, -0.078125]);
/// ```
pub fn closure(edges_of_faces: &[[u32; 3]], at_boundary: &[bool], probabilities: &[f32]) -> Term {
    let entries = edges_of_faces.iter().zip(0..).flat_map(|(edges, face)| edges.map(|edge| [edge, face]));
    let faces = Csr::from_entries(at_boundary.len(), edges_of_faces.len(), entries);
    let count_faces = |edge: usize| {
        let kept: Vec<f64> = faces.row(edge).iter().map(|&t| f64::from(probabilities[t as usize])).collect();
        edge_chances(&kept, at_boundary[edge])
    };
    let edges = parallel::map(faces.n_rows(), 256, count_faces);
    let wrong: f64 = edges.iter().map(|edge| edge.wrong).sum();
    let used: f64 = edges.iter().map(|edge| edge.used).sum();
    if used <= 0.0 {
        return Term { value: if edges_of_faces.is_empty() { 0.0 } else { 1.0 }, ..Term::zero(probabilities.len()) };
    }
    let mut gradient = vec![0.0f64; probabilities.len()];
    for (row, edge) in edges.iter().enumerate() {
        for (&t, [wrong_slope, used_slope]) in faces.row(row).iter().zip(&edge.slopes) {
            gradient[t as usize] += wrong_slope - wrong / used * used_slope;
        }
    }
    let gradient = gradient.into_iter().map(|slope| (slope / used) as f32).collect();
    Term { value: wrong / used, gradient }
}

/// Probabilities of an edge.
struct EdgeChances {
    /// That it has a wrong number of faces.
    wrong: f64,
    /// That it has a face.
    used: f64,
    /// Derivatives of both by the probability of each of its faces.
    slopes: Vec<[f64; 2]>,
}

type CountProbabilities = [f64; 3];

fn edge_chances(p: &[f64], at_boundary: bool) -> EdgeChances {
    // The distributions of the number of kept faces before and after face i give the derivative by its probability
    // without a division.
    let mut before = vec![[1.0, 0.0, 0.0]];
    before.extend(p.iter().scan([1.0, 0.0, 0.0], |counts, &p| {
        *counts = add_face(*counts, p);
        Some(*counts)
    }));
    let [none, one, two] = before[p.len()];
    let more_than_two = (1.0 - none - one - two).max(0.0);
    let wrong = if at_boundary { two + more_than_two } else { one + more_than_two };
    let mut slopes = vec![[0.0; 2]; p.len()];
    let mut after: CountProbabilities = [1.0, 0.0, 0.0];
    for (i, &p) in p.iter().enumerate().rev() {
        let [none, one, two] = combine_counts(before[i], after);
        // Keeping face i turns zero kept faces into one, and two into too many.
        slopes[i] = [if at_boundary { one } else { none - one + two }, none];
        after = add_face(after, p);
    }
    EdgeChances { wrong, used: 1.0 - none, slopes }
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
        let used = |kept: u32| (0..at_boundary.len()).filter(|&edge| count(kept, edge) > 0).count() as f64;
        let expected = |number: &dyn Fn(u32) -> f64| -> f64 {
            (0..1 << n).map(|kept| chance(kept).product::<f64>() * number(kept)).sum()
        };
        expected(&wrong) / expected(&used)
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
    fn a_closed_surface_costs_nothing_a_hole_its_edges_and_a_thin_surface_all() {
        let tetrahedron = [[0, 1, 2], [0, 3, 4], [1, 3, 5], [2, 4, 5]];
        let loss = |p: [f32; 4]| closure(&tetrahedron, &[false; 6], &p);
        assert_eq!(loss([1.0; 4]).value, 0.0);
        assert_eq!(loss([0.0; 4]).value, 1.0);
        assert!(loss([1e-4; 4]).value > 0.999 && loss([1e-4; 4]).gradient.iter().all(|&g| g < 0.0));
        assert_eq!(loss([1.0, 1.0, 1.0, 0.0]).value, 0.5);
        assert!(loss([1.0, 1.0, 1.0, 0.5]).gradient[3] < 0.0, "the hole wants its face");
    }

    #[test]
    fn nothing_is_fine() {
        assert_eq!(closure(&[], &[], &[]), Term::zero(0));
        assert_eq!(closure(&[], &[false; 3], &[]), Term::zero(0));
    }
}
