//! A DevConv over positions and normals and the two layers after it, row by row: nothing between them is ever held as a whole.
//!
//! For one layer of few columns over few inputs, mapping every neighbour again costs less than the memory of mapping it
//! once.

use super::isa::{ColumnKernel, Isa, RowKernel, fused, relu};
use super::product::multiply_rows;
use super::two_layers::layers;
use super::{Csr, Matrix};
use std::ops::Range;

/// Computes [`two_layers`](super::two_layers) of [`neighbour_max_product_relu`](super::neighbour_max_product_relu) of
/// `[a | b] theta`.
///
/// # Shapes
/// - `a`, `b`: n x 3
/// - `graph`: n rows, columns below n
/// - `[theta, phi]`: 6 x width and width x n_in
/// - `first`, `second`: as for [`two_layers`](super::two_layers)
/// - returns n x n_out
///
/// # Panics
/// When the shapes do not match.
///
/// ```
/// use neural_mesh::linalg::{Csr, Matrix, scored_dev_conv};
/// let number = |x: f32| Matrix::new(1, 1, vec![x]);
/// let [a, b] = [Matrix::new(2, 3, vec![7.0, 0.0, 0.0, 4.0, 0.0, 0.0]), Matrix::zeros(2, 3)];
/// let theta = Matrix::from_fn(6, 1, |row, _| if row == 0 { 1.0 } else { 0.0 });
/// let edge = Csr::from_edges(2, [[0, 1]]);
/// let layers = [[&number(1.0), &number(0.5)], [&number(10.0), &number(0.0)]];
/// assert_eq!(scored_dev_conv([&a, &b], &edge, [&theta, &number(2.0)], layers).data(), [65.0, 5.0]);
/// ```
pub fn scored_dev_conv(
    x: [&Matrix; 2],
    graph: &Csr,
    dev_conv: [&Matrix; 2],
    [first, second]: [[&Matrix; 2]; 2],
) -> Matrix {
    scored_on(Isa::best(), x, graph, dev_conv, [first, second])
}

fn scored_on(
    isa: Isa,
    [a, b]: [&Matrix; 2],
    graph: &Csr,
    [theta, phi]: [&Matrix; 2],
    [first, second]: [[&Matrix; 2]; 2],
) -> Matrix {
    let n = graph.n_rows();
    assert_eq!([a.shape(), b.shape(), [n, graph.n_cols()]], [[n, 3], [n, 3], [n, n]], "one graph node per row");
    assert_eq!([theta.n_rows(), phi.n_rows()], [6, theta.n_cols()], "theta takes both parts to phi");
    assert_eq!(first[0].shape(), [phi.n_cols(), second[0].n_rows()], "the layers follow each other");
    assert_eq!([first[1].n_cols(), second[1].n_cols()], [first[0].n_cols(), second[0].n_cols()], "one bias per column");
    let kernel = Scored { largest: Largest { a, b, graph, theta }, phi, first, second };
    isa.matrix(&kernel, n, second[0].n_cols())
}

struct Scored<'a> {
    largest: Largest<'a>,
    phi: &'a Matrix,
    first: [&'a Matrix; 2],
    second: [&'a Matrix; 2],
}

impl RowKernel for Scored<'_> {
    #[inline(always)]
    fn compute<const FMA: bool>(&self, rows: Range<usize>, out: &mut [f32]) {
        let [width, n_in] = self.phi.shape();
        let (mut largest, mut features) = (vec![0.0; rows.len() * width], vec![0.0; rows.len() * n_in]);
        self.largest.compute::<FMA>(rows, &mut largest);
        multiply_rows::<FMA>(&largest, self.phi, &mut features);
        features.iter_mut().for_each(|y| *y = relu(*y));
        layers::<FMA>(&features, self.first, self.second, out);
    }
}

/// `max_j (u_i - u_j)` with `u = [a | b] theta`, each `u_j` computed where it is met.
struct Largest<'a> {
    a: &'a Matrix,
    b: &'a Matrix,
    graph: &'a Csr,
    theta: &'a Matrix,
}

impl ColumnKernel for Largest<'_> {
    fn width(&self) -> usize {
        self.theta.n_cols()
    }

    #[inline(always)]
    fn columns<const COLS: usize, const FMA: bool>(&self, i: usize, col: usize, out: &mut [f32; COLS]) {
        if self.graph.row(i).is_empty() {
            return;
        }
        let mut smallest = [f32::INFINITY; COLS];
        for &j in self.graph.row(i) {
            let other = self.mapped::<COLS, FMA>(j as usize, col);
            for c in 0..COLS {
                smallest[c] = smallest[c].min(other[c]);
            }
        }
        let own = self.mapped::<COLS, FMA>(i, col);
        for c in 0..COLS {
            out[c] = own[c] - smallest[c];
        }
    }
}

impl Largest<'_> {
    #[inline(always)]
    fn mapped<const COLS: usize, const FMA: bool>(&self, row: usize, col: usize) -> [f32; COLS] {
        let ([a, b, c], [d, e, f]) = (*self.a.window::<3>(row, 0), *self.b.window::<3>(row, 0));
        let mut sums = [0.0; COLS];
        for (k, x) in [a, b, c, d, e, f].into_iter().enumerate() {
            let theta = self.theta.window::<COLS>(k, col);
            for c in 0..COLS {
                sums[c] = fused::<FMA>(x, theta[c], sums[c]);
            }
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_values::{assert_close, ragged_graph, random};
    use super::super::{concat_product, neighbour_max_product_relu, two_layers};
    use super::*;

    #[test]
    fn every_instruction_set_agrees_with_one_step_after_the_other() {
        for isa in Isa::available() {
            for [n, width, n_hidden] in [[0, 4, 4], [131, 16, 16], [90, 37, 5]] {
                let (a, b, graph) = (random(n, 3, 1), random(n, 3, 2), ragged_graph(n));
                let (theta, phi) = (random(6, width, 3), random(width, 20, 4));
                let first = [&random(20, n_hidden, 5), &random(1, n_hidden, 6)];
                let second = [&random(n_hidden, 1, 7), &random(1, 1, 8)];
                let features = neighbour_max_product_relu(&concat_product(&a, &b, &theta), &graph, &phi);
                let expected = two_layers(&features, first, second);
                let result = scored_on(isa, [&a, &b], &graph, [&theta, &phi], [first, second]);
                assert_close(result.data(), expected.data(), 1e-5);
            }
        }
    }
}
