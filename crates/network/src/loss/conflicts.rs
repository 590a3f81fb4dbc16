//! Cost of conflicting triangles: Eq. (9) and the form used in training.
//!
//! A conflict is an ordered pair (t, u): t passes through, crosses or overlaps u.

use super::Term;
use super::triangles::barycenters;
use crate::linalg::Csr;
use crate::parallel;
use crate::spatial::nearest_neighbours;

/// Triangles that a thread takes together.
const ROWS: usize = 64;

/// Joins every triangle with the `k` others of nearest barycenter.
pub(super) fn near_in_space(points: &[[f32; 3]], triangles: &[[u32; 3]], k: usize) -> Csr {
    let nearest = nearest_neighbours(&barycenters(points, triangles), k);
    Csr::from_equal_rows(triangles.len(), triangles.len(), nearest.len() / triangles.len().max(1), nearest)
}

/// Finds the pairs (t, u) in conflict, sorted, among triangles of which one is a neighbour of the other.
pub(super) fn near_pairs(neighbours: &Csr, in_conflict: impl Fn(u32, u32) -> bool + Sync) -> Vec<[u32; 2]> {
    let both_ways = Csr::from_edges(neighbours.n_rows(), neighbours.entries());
    let of_triangle = |t: usize| {
        let pairs = both_ways.row(t).iter().map(move |&u| [t as u32, u]);
        pairs.filter(|&[t, u]| in_conflict(t, u))
    };
    parallel::flat_map(0..both_ways.n_rows(), ROWS, of_triangle).collect()
}

/// Computes Eq. (9) as printed, `1/|F_s| sum_t p_t m(t)`; m(t) counts the pairs (t, u).
///
/// Its minimum is the empty mesh: all probabilities 0.
///
/// # Shapes
/// - `conflicts`: pairs from [`collisions`](super::collisions), [`edge_crossings`](super::edge_crossings) or
///   [`overlaps`](super::overlaps)
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::loss::conflicts_by_count;
/// let term = conflicts_by_count(&[[0, 1], [0, 2], [1, 0]], &[0.5, 0.25, 1.0, 1.0]);
/// assert_eq!((term.value, term.gradient), ((0.5 * 2.0 + 0.25) / 4.0, vec![0.5, 0.25, 0.0, 0.0]));
/// ```
pub fn conflicts_by_count(conflicts: &[[u32; 2]], probabilities: &[f32]) -> Term {
    let mut counts = vec![0.0f64; probabilities.len()];
    conflicts.iter().for_each(|&[t, _]| counts[t as usize] += 1.0);
    Term::mean_product(&counts, probabilities)
}

/// Computes `1/|F_s| sum_(t, u) p_t p_u`: the expected number of conflicts among kept faces, per candidate.
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::loss::conflicts_by_pair;
/// let term = conflicts_by_pair(&[[0, 1], [1, 0]], &[0.5, 0.25]);
/// assert_eq!((term.value, term.gradient), (0.125, vec![0.25, 0.5]));
/// ```
pub fn conflicts_by_pair(conflicts: &[[u32; 2]], probabilities: &[f32]) -> Term {
    let mut gradient = vec![0.0f64; probabilities.len()];
    let mut sum = 0.0;
    for [t, u] in conflicts.iter().map(|pair| pair.map(|t| t as usize)) {
        let (p_t, p_u) = (f64::from(probabilities[t]), f64::from(probabilities[u]));
        sum += p_t * p_u;
        gradient[t] += p_u;
        gradient[u] += p_t;
    }
    Term::mean(sum, &gradient, probabilities.len())
}

#[cfg(test)]
mod tests {
    use super::super::test_gradients::{assert_gradient, uniform};
    use super::*;

    const CONFLICTS: [[u32; 2]; 5] = [[0, 1], [1, 0], [2, 0], [4, 1], [4, 2]];

    #[test]
    fn gradients_agree_with_differences() {
        assert_gradient(&uniform(6, 1), 1e-4, |p| conflicts_by_count(&CONFLICTS, p));
        assert_gradient(&uniform(6, 2), 1e-4, |p| conflicts_by_pair(&CONFLICTS, p));
    }

    #[test]
    fn the_empty_mesh_is_the_minimum_of_the_print_and_pairs_let_one_stay() {
        assert_eq!(conflicts_by_count(&CONFLICTS, &[0.0; 6]).value, 0.0);
        assert!(conflicts_by_count(&CONFLICTS, &[0.5; 6]).gradient.iter().all(|&g| g >= 0.0));
        let one_stays = conflicts_by_pair(&[[0, 1], [1, 0]], &[1.0, 0.0]);
        assert_eq!((one_stays.value, one_stays.gradient[0]), (0.0, 0.0));
    }

    #[test]
    fn pairs_are_near_both_ways() {
        let neighbours = Csr::from_entries(3, 3, [[0, 1], [1, 2], [2, 1]].into_iter());
        assert_eq!(near_pairs(&neighbours, |_, _| true), [[0, 1], [1, 0], [1, 2], [2, 1]]);
        assert_eq!(near_pairs(&neighbours, |t, u| t > u), [[1, 0], [2, 1]]);
    }

    #[test]
    fn nothing_is_fine() {
        assert_eq!(conflicts_by_count(&[], &[]), Term::zero(0));
        assert_eq!(conflicts_by_pair(&[], &[]), Term::zero(0));
        assert!(near_pairs(&Csr::from_edges(0, []), |_, _| true).is_empty());
    }
}
