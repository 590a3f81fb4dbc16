//! How far the eigenpairs of a simplified mesh are from those of its original: the paper's LE (Sec. 4.1), made definite.
//!
//! The paper takes the mean squared error "between the first 200 eigenvectors" of meshes of different size. Here the
//! simplified mesh's eigenfunctions are carried over to the original's vertices, all functions have mean square 1, and
//! signs and bases of (nearly) equal eigenvalues, which mean nothing, are chosen to fit best.

use std::ops::Range;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use rayon::prelude::*;

use super::carried::Carried;
use super::eigenpairs::Eigenpairs;

/// Eigenvalues of the original closer than this share of their mean spacing count as one.
const SAME: f64 = 0.1;

/// Errors over eigenpairs. Those that a simplified mesh of too few vertices does not have count as such that fit nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpectrumError {
    /// Mean squared error of the eigenfunctions, each of mean square 1; 2 where nothing fits.
    pub functions: f64,
    /// Mean share of a carried eigenfunction that lies outside of the span of the original's, 0 to 1; it does not see
    /// eigenfunctions that change places.
    pub span: f64,
    /// Mean error of the eigenvalues, as a share of the original's; 1 where there is none.
    pub values: f64,
}

/// Measures the first `n_pairs`, at most as many as the original's; `mass` are the original's.
pub fn spectrum_error(
    mass: &[f64],
    original: &Eigenpairs,
    simplified: &Eigenpairs,
    carried: &Carried,
    simplified_area: f64,
    n_pairs: usize,
) -> SpectrumError {
    let n_found = n_pairs.min(simplified.values.len());
    let ratio = simplified_area / mass.iter().sum::<f64>();
    let functions: Vec<Vec<f64>> =
        (0..n_found).into_par_iter().map(|pair| carried.values(simplified.function(pair))).collect();
    let square = |u: &Vec<f64>| ratio * u.iter().zip(mass).map(|(u, m)| m * u * u).sum::<f64>();
    let squares: Vec<f64> = functions.iter().map(square).collect();
    let inner = inner_products(mass, original, &functions, ratio.sqrt());
    let groups = groups(&original.values[..n_found], SAME * original.spacing());
    SpectrumError {
        functions: with_missing(functions_error(&groups, &squares, &inner), n_found, n_pairs, 2.0),
        span: with_missing(span_error(&squares, &inner), n_found, n_pairs, 1.0),
        values: with_missing(values_error(original, simplified, n_found), n_found, n_pairs, 1.0),
    }
}

/// The mean over `n_pairs` errors, of which those beyond `n_found` are `missing`.
fn with_missing(mean: f64, n_found: usize, n_pairs: usize, missing: f64) -> f64 {
    let found = n_found as f64 / n_pairs.max(1) as f64;
    found * mean + (1.0 - found) * missing
}

/// Inner products of the original's functions (rows) with carried ones (columns), as if all had mean square 1.
fn inner_products(mass: &[f64], original: &Eigenpairs, carried: &[Vec<f64>], scale: f64) -> Mat<f64> {
    let n_pairs = carried.len();
    let theirs = Mat::from_fn(mass.len(), n_pairs, |i, pair| scale * mass[i] * carried[pair][i]);
    let mut inner = Mat::zeros(n_pairs, n_pairs);
    matmul(&mut inner, Accum::Replace, original.first(n_pairs).transpose(), &theirs, 1.0, Par::Seq);
    inner
}

/// Over groups of equal eigenvalues: squares of both sides less twice the best inner product that turning one of the
/// groups can reach, which is the sum of singular values (Procrustes: Schoenemann 1966).
fn functions_error(groups: &[Range<usize>], squares: &[f64], inner: &Mat<f64>) -> f64 {
    let of_group = |group: &Range<usize>| {
        let block = inner.submatrix(group.start, group.start, group.len(), group.len());
        let best: f64 = block.singular_values().map_or(0.0, |values| values.iter().sum());
        group.len() as f64 + squares[group.clone()].iter().sum::<f64>() - 2.0 * best
    };
    groups.iter().map(of_group).sum::<f64>() / squares.len().max(1) as f64
}

/// Runs of ascending values with no step larger than `same`.
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

    /// Turned by 30 degrees within a group there is no error, turned so across groups there is all of it.
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
