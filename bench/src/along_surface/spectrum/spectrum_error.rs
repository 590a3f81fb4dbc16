//! Errors of a simplified mesh's eigenpairs: the paper's LE (Sec. 4.1), made precise.

use std::ops::Range;

use nalgebra::DMatrix;

use super::eigenpairs::Eigenpairs;
use super::slabs;
use super::symmetric::MOST_ITERATIONS;
use super::value_transfer::ValueTransfer;
use neural_mesh::parallel;

// Eigenvalues nearer than this fraction of their mean spacing count as equal.
const SAME: f64 = 0.1;
// Error of an eigenfunction that the simplified mesh lacks.
const MISSING: f64 = 2.0;

/// Returns the mean squared error of the first `n_pairs` eigenfunctions, each of mean square 1.
///
/// It is 2 without any agreement, which is also the error of a pair that the simplified mesh lacks.
pub fn spectrum_error(
    mass: &[f64],
    original: &Eigenpairs,
    simplified: &Eigenpairs,
    transfer: &ValueTransfer,
    simplified_area: f64,
    n_pairs: usize,
) -> f64 {
    let n_found = n_pairs.min(simplified.values.len());
    let ratio = simplified_area / mass.iter().sum::<f64>();
    let functions = parallel::map(n_found, 1, |pair| transfer.values(simplified.function(pair)));
    let square = |u: &Vec<f64>| ratio * u.iter().zip(mass).map(|(u, m)| m * u * u).sum::<f64>();
    let squares: Vec<f64> = functions.iter().map(square).collect();
    let inner = inner_products(mass, original, &functions, ratio.sqrt());
    let groups = groups(&original.values[..n_found], SAME * original.spacing());
    let found = n_found as f64 / n_pairs.max(1) as f64;
    found * functions_error(&groups, &squares, &inner) + (1.0 - found) * MISSING
}

fn inner_products(mass: &[f64], original: &Eigenpairs, carried: &[Vec<f64>], scale: f64) -> DMatrix<f64> {
    let n_pairs = carried.len();
    let theirs = DMatrix::from_fn(mass.len(), n_pairs, |i, pair| scale * mass[i] * carried[pair][i]);
    slabs::inner_products(&original.first_functions(n_pairs), &theirs)
}

fn functions_error(groups: &[Range<usize>], squares: &[f64], inner: &DMatrix<f64>) -> f64 {
    let of_group = |group: &Range<usize>| {
        let block = inner.view((group.start, group.start), (group.len(), group.len()));
        // The best rotation within the group (Procrustes: Schoenemann 1966) fits signs and bases.
        let best = block
            .try_svd(false, false, f64::EPSILON, MOST_ITERATIONS * group.len())
            .map_or(0.0, |svd| svd.singular_values.sum());
        group.len() as f64 + squares[group.clone()].iter().sum::<f64>() - 2.0 * best
    };
    groups.iter().map(of_group).sum::<f64>() / squares.len().max(1) as f64
}

fn groups(values: &[f64], same: f64) -> Vec<Range<usize>> {
    let mut start = 0;
    let runs = values.chunk_by(|a, b| b - a <= same);
    runs.map(|run| {
        start += run.len();
        start - run.len()..start
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_of_equal_values_are_groups() {
        assert_eq!(groups(&[0.0, 1.0, 1.05, 1.1, 2.0], 0.1), [0..1, 1..4, 4..5]);
        assert!(groups(&[], 0.1).is_empty());
    }

    // Eigenfunctions turned by 30 degrees give no error within a group of equal eigenvalues, and full error across
    // groups.
    #[test]
    fn turns_within_a_group_are_free() {
        let (sin, cos) = 30f64.to_radians().sin_cos();
        let mut turned = DMatrix::<f64>::identity(3, 3);
        (turned[(1, 1)], turned[(1, 2)], turned[(2, 1)], turned[(2, 2)]) = (-cos, sin, sin, cos);
        let squares = [1.0; 3];
        assert!(functions_error(&[0..1, 1..3], &squares, &turned).abs() < 1e-12);
        let apart = functions_error(&[0..1, 1..2, 2..3], &squares, &turned);
        assert!((apart - 2.0 * (2.0 - 2.0 * cos) / 3.0).abs() < 1e-12);
    }

    #[test]
    fn unrelated_functions_are_two_apart() {
        let nothing = DMatrix::zeros(2, 2);
        assert_eq!(functions_error(&[0..1, 1..2], &[1.0; 2], &nothing), 2.0);
    }
}
