//! Errors of a simplified mesh's eigenpairs: the paper's LE (Sec. 4.1), made precise.

use std::ops::Range;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use rayon::prelude::*;

use super::eigenpairs::Eigenpairs;
use super::value_transfer::ValueTransfer;

// Eigenvalues nearer than this fraction of their mean spacing count as equal.
const SAME: f64 = 0.1;

// Errors of the eigenpairs; a pair that the simplified mesh lacks counts with the largest error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpectrumError {
    // Mean squared error of the eigenfunctions, which have mean square 1; 2 without any agreement.
    pub functions: f64,
    // Mean fraction of an eigenfunction outside the span of the original's eigenfunctions, 0 to 1.
    pub span: f64,
    // The mean relative error of the eigenvalues; 1 for missing ones.
    pub values: f64,
}

pub fn spectrum_error(
    mass: &[f64],
    original: &Eigenpairs,
    simplified: &Eigenpairs,
    transfer: &ValueTransfer,
    simplified_area: f64,
    n_pairs: usize,
) -> SpectrumError {
    let n_found = n_pairs.min(simplified.values.len());
    let ratio = simplified_area / mass.iter().sum::<f64>();
    let functions: Vec<Vec<f64>> =
        (0..n_found).into_par_iter().map(|pair| transfer.values(simplified.function(pair))).collect();
    let square = |u: &Vec<f64>| ratio * u.iter().zip(mass).map(|(u, m)| m * u * u).sum::<f64>();
    let squares: Vec<f64> = functions.iter().map(square).collect();
    let inner = inner_products(mass, original, &functions, ratio.sqrt());
    let groups = groups(&original.values[..n_found], SAME * original.spacing());
    SpectrumError {
        functions: extend_mean(functions_error(&groups, &squares, &inner), n_found, n_pairs, 2.0),
        span: extend_mean(span_error(&squares, &inner), n_found, n_pairs, 1.0),
        values: extend_mean(values_error(original, simplified, n_found), n_found, n_pairs, 1.0),
    }
}

fn extend_mean(mean: f64, n_found: usize, n_pairs: usize, missing: f64) -> f64 {
    let found = n_found as f64 / n_pairs.max(1) as f64;
    found * mean + (1.0 - found) * missing
}

fn inner_products(mass: &[f64], original: &Eigenpairs, carried: &[Vec<f64>], scale: f64) -> Mat<f64> {
    let n_pairs = carried.len();
    let theirs = Mat::from_fn(mass.len(), n_pairs, |i, pair| scale * mass[i] * carried[pair][i]);
    let mut inner = Mat::zeros(n_pairs, n_pairs);
    matmul(&mut inner, Accum::Replace, original.first_functions(n_pairs).transpose(), &theirs, 1.0, Par::Seq);
    inner
}

fn functions_error(groups: &[Range<usize>], squares: &[f64], inner: &Mat<f64>) -> f64 {
    let of_group = |group: &Range<usize>| {
        let block = inner.submatrix(group.start, group.start, group.len(), group.len());
        // The best rotation within the group (Procrustes: Schoenemann 1966) fits signs and bases.
        let best: f64 = block.singular_values().map_or(0.0, |values| values.iter().sum());
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

fn span_error(squares: &[f64], inner: &Mat<f64>) -> f64 {
    let outside = |(pair, square): (usize, &f64)| {
        let inside = inner.col(pair).squared_norm_l2();
        if *square > 0.0 { (1.0 - inside / square).max(0.0) } else { 1.0 }
    };
    squares.iter().enumerate().map(outside).sum::<f64>() / squares.len().max(1) as f64
}

fn values_error(original: &Eigenpairs, simplified: &Eigenpairs, n_pairs: usize) -> f64 {
    let pairs = (0..n_pairs).filter(|&pair| !original.is_constant(pair));
    let errors: Vec<f64> = pairs.map(|pair| (simplified.values[pair] / original.values[pair] - 1.0).abs()).collect();
    errors.iter().sum::<f64>() / errors.len().max(1) as f64
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
        let mut turned = Mat::<f64>::identity(3, 3);
        (turned[(1, 1)], turned[(1, 2)], turned[(2, 1)], turned[(2, 2)]) = (-cos, sin, sin, cos);
        let squares = [1.0; 3];
        assert!(functions_error(&[0..1, 1..3], &squares, &turned).abs() < 1e-12);
        let apart = functions_error(&[0..1, 1..2, 2..3], &squares, &turned);
        assert!((apart - 2.0 * (2.0 - 2.0 * cos) / 3.0).abs() < 1e-12);
        assert!(span_error(&squares, &turned) < 1e-12);
    }

    #[test]
    fn unrelated_functions_are_two_apart() {
        let nothing = Mat::zeros(2, 2);
        assert_eq!(functions_error(&[0..1, 1..2], &[1.0; 2], &nothing), 2.0);
        assert_eq!(span_error(&[1.0; 2], &nothing), 1.0);
    }
}
