//! The lowest eigenvalues and eigenfunctions of a surface's Laplacian.

use faer::{Mat, MatMut, MatRef, Side};
use rayon::prelude::*;

use super::factor::Factor;
use super::lanczos;
use super::pieces::{Piece, pieces};
use crate::along_surface::laplacian::Laplacian;

/// Pieces with so few vertices, or not three times as many as pairs, are solved as dense matrices.
const DENSE: usize = 400;

/// The lowest eigenpairs of `L u = lambda M u`.
#[derive(Clone, Debug)]
pub struct Eigenpairs {
    /// Eigenvalues in inverse squares of the mesh's unit, ascending, at least 0: n_pairs.
    pub values: Vec<f64>,
    /// Eigenfunctions at the places of [`Laplacian::vertices`], as columns, orthonormal under the masses: n x n_pairs.
    functions: Mat<f64>,
}

impl Eigenpairs {
    /// Solves for the `n_pairs` lowest, at most n; `None` where the solver fails.
    ///
    /// Piece by piece, so that eigenvalues that equal pieces share are found as often as they are there; each by
    /// shift-invert block Lanczos over a sparse Cholesky factor. Within a piece an eigenvalue that is there more than eight
    /// times may be found fewer times.
    ///
    /// ```
    /// use neural_mesh::mesh::shapes;
    /// use neural_mesh_bench::along_surface::{Eigenpairs, Laplacian};
    /// let sphere = Laplacian::new(&shapes::icosphere(3)).unwrap();
    /// let values = Eigenpairs::lowest(&sphere, 4).unwrap().values;
    /// assert!(values[0] < 1e-9 && values[1..].iter().all(|value| (value - 2.0).abs() < 0.02));
    /// ```
    pub fn lowest(laplacian: &Laplacian, n_pairs: usize) -> Option<Self> {
        let n = laplacian.mass.len();
        let mut pieces = pieces(laplacian);
        // Each piece has one constant function: those of more pieces are not asked for.
        pieces.truncate(n_pairs);
        let solved = solve_pieces(&pieces, n_pairs.min(n))?;
        if let [whole] = &solved[..] {
            return Some(whole.clone());
        }
        let chosen = lowest_of(&solved, n_pairs.min(n));
        let mut functions = Mat::zeros(n, chosen.len());
        for (pair, &(piece, index)) in chosen.iter().enumerate() {
            let function = solved[piece].functions.col(index).iter();
            pieces[piece].places.iter().zip(function).for_each(|(&at, &u)| functions[(at as usize, pair)] = u);
        }
        Some(Self { values: chosen.iter().map(|&(piece, index)| solved[piece].values[index]).collect(), functions })
    }

    /// The eigenfunction of an eigenvalue, at the places of [`Laplacian::vertices`]: n.
    pub fn function(&self, pair: usize) -> &[f64] {
        self.functions.col_as_slice(pair)
    }

    /// The eigenfunctions of the first eigenvalues, as columns, n x n_pairs.
    pub(super) fn first(&self, n_pairs: usize) -> MatRef<'_, f64> {
        self.functions.subcols(0, n_pairs)
    }

    /// By Weyl's law the eigenvalues are evenly spaced, about this far apart; 0 where there is only one.
    pub fn spacing(&self) -> f64 {
        self.values.last().map_or(0.0, |last| last / (self.values.len() - 1).max(1) as f64)
    }
}

/// Enough eigenpairs of each piece for the `n_pairs` lowest of all; the functions at the places of the piece.
fn solve_pieces(pieces: &[Piece], n_pairs: usize) -> Option<Vec<Eigenpairs>> {
    let area: f64 = pieces.iter().map(Piece::area).sum();
    // By Weyl's law a piece has as many as its share of the area,
    let first = |piece: &Piece| (1 + (n_pairs as f64 * piece.area() / area).ceil() as usize).min(n_pairs);
    // and of as many pieces as pairs the constants are enough.
    let first = |piece: &Piece| if pieces.len() >= n_pairs { 1 } else { first(piece) };
    let mut solved: Vec<Eigenpairs> =
        pieces.par_iter().map(|piece| solve(piece, first(piece))).collect::<Option<_>>()?;
    loop {
        let chosen = lowest_of(&solved, n_pairs);
        let is_full = chosen.len() == n_pairs;
        let highest = chosen.last().filter(|_| is_full).map_or(f64::INFINITY, |&(piece, i)| solved[piece].values[i]);
        let more = |(piece, pairs): (&Piece, &mut Eigenpairs)| {
            let known = pairs.values.len();
            let is_short = known < piece.places.len().min(n_pairs) && pairs.values[known - 1] < highest;
            if is_short {
                *pairs = solve(piece, (2 * known).min(n_pairs))?;
            }
            Some(is_short)
        };
        let grown: Vec<bool> = pieces.par_iter().zip(&mut solved).map(more).collect::<Option<_>>()?;
        if !grown.contains(&true) {
            return Some(solved);
        }
    }
}

/// The `n_pairs` lowest of all pieces' eigenpairs, each as its piece and its place there.
fn lowest_of(solved: &[Eigenpairs], n_pairs: usize) -> Vec<(usize, usize)> {
    let of_piece = |piece: usize| (0..solved[piece].values.len()).map(move |index| (piece, index));
    let mut all: Vec<(usize, usize)> = (0..solved.len()).flat_map(of_piece).collect();
    let value = |&(piece, index): &(usize, usize)| solved[piece].values[index];
    all.sort_by(|a, b| value(a).total_cmp(&value(b)));
    all.truncate(n_pairs);
    all
}

/// The lowest eigenpairs of a piece, at least one.
fn solve(piece: &Piece, n_pairs: usize) -> Option<Eigenpairs> {
    let n_pairs = n_pairs.min(piece.places.len());
    if n_pairs == 1 {
        let height = 1.0 / piece.area().sqrt();
        return Some(Eigenpairs { values: vec![0.0], functions: Mat::from_fn(piece.places.len(), 1, |_, _| height) });
    }
    let roots: Vec<f64> = piece.mass.iter().map(|mass| mass.sqrt()).collect();
    let solver = if roots.len() <= DENSE.max(3 * n_pairs) { dense } else { sparse };
    let (mut values, mut functions) = solver(piece, &roots, n_pairs)?;
    scale_rows(functions.as_mut(), &roots.iter().map(|root| 1.0 / root).collect::<Vec<_>>());
    values.iter_mut().for_each(|value| *value = value.max(0.0));
    Some(Eigenpairs { values, functions })
}

/// By all eigenpairs of `M^-1/2 L M^-1/2`.
fn dense(piece: &Piece, roots: &[f64], n_pairs: usize) -> Option<(Vec<f64>, Mat<f64>)> {
    let mut matrix = Mat::<f64>::zeros(roots.len(), roots.len());
    for &([i, j], weight) in &piece.edges {
        let (i, j) = (i as usize, j as usize);
        matrix[(i, i)] += weight / (roots[i] * roots[i]);
        matrix[(j, j)] += weight / (roots[j] * roots[j]);
        matrix[(j, i)] -= weight / (roots[i] * roots[j]);
    }
    let eigen = matrix.self_adjoint_eigen(Side::Lower).ok()?;
    let values = (0..n_pairs).map(|i| eigen.S().column_vector()[i]).collect();
    Some((values, eigen.U().subcols(0, n_pairs).to_owned()))
}

/// By the largest eigenpairs of `M^1/2 (L + s M)^-1 M^1/2`, the shift s about as large as the first eigenvalue.
fn sparse(piece: &Piece, roots: &[f64], n_pairs: usize) -> Option<(Vec<f64>, Mat<f64>)> {
    let shift = 4.0 * std::f64::consts::PI / piece.area();
    let factor = Factor::new(&piece.mass, &piece.edges, 1.0, shift)?;
    let apply = |mut block: MatMut<'_, f64>| {
        scale_rows(block.as_mut(), roots);
        factor.solve_in_place(block.as_mut());
        scale_rows(block, roots);
    };
    let (inverse, functions) = lanczos::largest(roots.len(), n_pairs, apply)?;
    Some((inverse.into_iter().map(|value| 1.0 / value - shift).collect(), functions))
}

fn scale_rows(mut matrix: MatMut<'_, f64>, by: &[f64]) {
    for j in 0..matrix.ncols() {
        by.iter().enumerate().for_each(|(i, factor)| matrix[(i, j)] *= factor);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use neural_mesh::mesh::{TriMesh, shapes};

    fn lowest(mesh: &TriMesh, n_pairs: usize) -> Eigenpairs {
        Eigenpairs::lowest(&Laplacian::new(mesh).unwrap(), n_pairs).unwrap()
    }

    /// l (l + 1), each 2 l + 1 times.
    #[test]
    fn eigenvalues_of_the_sphere() {
        let values = lowest(&shapes::icosphere(4), 49).values;
        let wanted = (0..7).flat_map(|l| std::iter::repeat_n(f64::from(l * (l + 1)), 2 * l as usize + 1));
        for (value, wanted) in values.iter().zip(wanted) {
            assert!((value - wanted).abs() <= 0.02 * wanted + 1e-9, "{value} {wanted}");
        }
    }

    /// pi^2 (i^2 + j^2), as no flow leaves the boundary.
    #[test]
    fn eigenvalues_of_the_square() {
        let values = lowest(&shapes::grid(40, 40), 20).values;
        let mut wanted: Vec<f64> = (0..40).map(|i| f64::from(i / 6 * (i / 6) + i % 6 * (i % 6))).collect();
        wanted.sort_by(f64::total_cmp);
        for (value, wanted) in values.iter().zip(wanted.iter().map(|w| w * std::f64::consts::PI.powi(2))) {
            assert!((value - wanted).abs() <= 0.01 * wanted + 1e-9, "{value} {wanted}");
        }
    }

    #[test]
    fn functions_are_eigenfunctions_and_orthonormal() {
        let laplacian = Laplacian::new(&shapes::wavy_sphere(3, 20.0)).unwrap();
        assert!(laplacian.mass.len() > DENSE);
        let pairs = Eigenpairs::lowest(&laplacian, 60).unwrap();
        for k in [0, 1, 30, 59] {
            let u = pairs.function(k);
            let mut left: Vec<f64> = u.iter().zip(&laplacian.mass).map(|(u, m)| -pairs.values[k] * m * u).collect();
            for &([i, j], weight) in &laplacian.edges {
                let flow = weight * (u[i as usize] - u[j as usize]);
                left[i as usize] += flow;
                left[j as usize] -= flow;
            }
            let error = left.iter().zip(&laplacian.mass).map(|(r, m)| r * r / m).sum::<f64>().sqrt();
            assert!(error < 1e-5 * (pairs.values[k] + 1.0), "{k} {error}");
            let inner = |l: usize| u.iter().zip(pairs.function(l)).zip(&laplacian.mass).map(|((a, b), m)| a * b * m);
            for l in 0..60 {
                assert!((inner(l).sum::<f64>() - f64::from(u8::from(k == l))).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn dense_and_sparse_agree() {
        let laplacian = Laplacian::new(&shapes::wavy_sphere(3, 20.0)).unwrap();
        let roots: Vec<f64> = laplacian.mass.iter().map(|mass| mass.sqrt()).collect();
        let piece = &pieces(&laplacian)[0];
        let (dense, _) = dense(piece, &roots, 60).unwrap();
        let (sparse, _) = sparse(piece, &roots, 60).unwrap();
        assert!(dense.iter().zip(&sparse).all(|(a, b)| (a - b).abs() < 1e-7 * (a + 1.0)), "{dense:?} {sparse:?}");
    }

    /// Twenty equal spheres have each eigenvalue of one of them twenty times.
    #[test]
    fn equal_pieces_have_equal_eigenvalues_each() {
        let sphere = shapes::icosphere(3);
        let (n, n_pieces) = (sphere.positions().len() as u32, 20u32);
        let shifted = |by: u32| sphere.positions().iter().map(move |p| [p[0] + 4.0 * by as f32, p[1], p[2]]);
        let faces = |by: u32| sphere.faces().iter().map(move |face| face.map(|v| v + by * n));
        let spheres =
            TriMesh::new((0..n_pieces).flat_map(shifted).collect(), (0..n_pieces).flat_map(faces).collect()).unwrap();
        let one = lowest(&sphere, 12).values;
        let laplacian = Laplacian::new(&spheres).unwrap();
        let all = Eigenpairs::lowest(&laplacian, 200).unwrap();
        for (pair, value) in all.values.iter().enumerate() {
            let wanted = one[pair / n_pieces as usize];
            assert!((value - wanted).abs() < 1e-4 * (wanted + 1e-2), "{pair} {value} {wanted}");
        }
        for k in [0, 19, 20, 79, 150, 199] {
            for l in [0, 20, 42, 150, 199] {
                let (u, v) = (all.function(k), all.function(l));
                let inner: f64 = u.iter().zip(v).zip(&laplacian.mass).map(|((a, b), m)| a * b * m).sum();
                assert!((inner - f64::from(u8::from(k == l))).abs() < 1e-9, "{k} {l} {inner}");
            }
        }
    }

    #[test]
    fn of_many_pieces_the_largest_constants_come_first() {
        let boxes = Laplacian::new(&shapes::many_boxes(6)).unwrap();
        let pairs = Eigenpairs::lowest(&boxes, 4).unwrap();
        assert_eq!(pairs.values, [0.0; 4]);
        assert_eq!(Eigenpairs::lowest(&boxes, usize::MAX).unwrap().values.len(), boxes.mass.len());
        assert!(Eigenpairs::lowest(&boxes, 0).unwrap().values.is_empty());
    }
}
