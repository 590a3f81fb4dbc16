//! A DevConv over positions and normals and two layers after it.

use super::group_layers::apply_layers;
use super::isa::{ColumnKernel, Isa, RowKernel, multiply_add, relu};
use super::product::multiply_rows;
use super::{Csr, Matrix};
use std::ops::Range;

/// Computes [`two_layers`](super::two_layers) of a DevConv, row by row.
///
/// The DevConv is [`neighbour_max_product_relu`](super::neighbour_max_product_relu) of `[a | b] theta`.
///
/// # Shapes
/// - `a`, `b`: n x 3; `graph`: n x n
/// - `[theta, phi]`: 6 x width and width x n_in
/// - `first`, `second`: as for [`two_layers`](super::two_layers)
/// - returns n x n_out
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::{Csr, Matrix, scored_dev_conv};
/// let number = |x: f32| Matrix::new(1, 1, vec![x]);
/// let [a, b] = [Matrix::new(2, 3, vec![7.0, 0.0, 0.0, 4.0, 0.0, 0.0]), Matrix::zeros(2, 3)];
/// let theta = Matrix::from_fn(6, 1, |row, _| if row == 0 { 1.0 } else { 0.0 });
/// let edge = Csr::from_edges(2, [[0, 1]]);
/// let layers = [[&number(1.0), &number(0.5)], [&number(10.0), &number(0.0)]];
/// assert_eq!(scored_dev_conv([&a, &b], &edge, [&theta, &number(2.0)], layers).data(), [65.0, 5.0]);
/// ```
pub fn scored_dev_conv(x: [&Matrix; 2], graph: &Csr, dev_conv: [&Matrix; 2], layers: [[&Matrix; 2]; 2]) -> Matrix {
    let n = graph.n_rows();
    let shapes = x.map(Matrix::shape);
    assert_eq!([shapes[0], shapes[1], [n, graph.n_cols()]], [[n, 3], [n, 3], [n, n]], "one graph node per row");
    let ([theta, phi], [first, second]) = (dev_conv, layers);
    assert_eq!([theta.n_rows(), phi.n_rows()], [6, theta.n_cols()], "sizes of theta and phi must match");
    assert_eq!(first[0].shape(), [phi.n_cols(), second[0].n_rows()], "sizes of consecutive layers must match");
    assert_eq!([first[1].n_cols(), second[1].n_cols()], [first[0].n_cols(), second[0].n_cols()], "one bias per column");
    let largest = StarMaxKernel { x: x.map(|x| x.data().as_chunks().0), graph, theta };
    Isa::best().compute_matrix(&ScoredDevConvKernel { largest, phi, first, second }, n, second[0].n_cols())
}

struct ScoredDevConvKernel<'a> {
    largest: StarMaxKernel<'a>,
    phi: &'a Matrix,
    first: [&'a Matrix; 2],
    second: [&'a Matrix; 2],
}

impl RowKernel for ScoredDevConvKernel<'_> {
    #[inline(always)]
    fn compute<const FMA: bool>(&self, rows: Range<usize>, out: &mut [f32]) {
        let [width, n_in] = self.phi.shape();
        let (mut largest, mut features) = (vec![0.0; rows.len() * width], vec![0.0; rows.len() * n_in]);
        self.largest.compute::<FMA>(rows, &mut largest);
        multiply_rows::<FMA>(&largest, self.phi, &mut features);
        features.iter_mut().for_each(|y| *y = relu(*y));
        apply_layers::<FMA>(&features, &[], &[self.first, self.second], out);
    }
}

struct StarMaxKernel<'a> {
    x: [&'a [[f32; 3]]; 2],
    graph: &'a Csr,
    theta: &'a Matrix,
}

impl ColumnKernel for StarMaxKernel<'_> {
    fn width(&self) -> usize {
        self.theta.n_cols()
    }

    #[inline(always)]
    fn columns<const COLS: usize, const FMA: bool>(&self, node: usize, col: usize, out: &mut [f32; COLS]) {
        let neighbours = self.graph.row(node);
        if neighbours.is_empty() {
            return;
        }
        let theta: [[f32; COLS]; 6] = std::array::from_fn(|k| *self.theta.window(k, col));
        let mut smallest = [f32::INFINITY; COLS];
        for &j in neighbours {
            let other = apply_theta::<COLS, FMA>(self.row(j as usize), &theta);
            for c in 0..COLS {
                smallest[c] = if other[c] < smallest[c] { other[c] } else { smallest[c] };
            }
        }
        let own = apply_theta::<COLS, FMA>(self.row(node), &theta);
        for c in 0..COLS {
            out[c] = own[c] - smallest[c];
        }
    }
}

impl StarMaxKernel<'_> {
    #[inline(always)]
    fn row(&self, node: usize) -> [f32; 6] {
        let ([a, b, c], [d, e, f]) = (self.x[0][node], self.x[1][node]);
        [a, b, c, d, e, f]
    }
}

#[inline(always)]
fn apply_theta<const COLS: usize, const FMA: bool>(row: [f32; 6], theta: &[[f32; COLS]; 6]) -> [f32; COLS] {
    let mut sums = [0.0; COLS];
    for (x, theta) in row.into_iter().zip(theta) {
        for c in 0..COLS {
            sums[c] = multiply_add::<FMA>(x, theta[c], sums[c]);
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::super::test_values::{assert_close, ragged_graph, random};
    use super::super::{concat_product, neighbour_max_product_relu, two_layers};
    use super::*;

    #[test]
    fn every_instruction_set_agrees_with_one_step_after_the_other() {
        Isa::on_each(|| {
            for [n, width, n_hidden] in [[0, 4, 4], [131, 16, 16], [90, 37, 5]] {
                let (a, b, graph) = (random(n, 3, 1), random(n, 3, 2), ragged_graph(n));
                let (theta, phi) = (random(6, width, 3), random(width, 20, 4));
                let first = [&random(20, n_hidden, 5), &random(1, n_hidden, 6)];
                let second = [&random(n_hidden, 1, 7), &random(1, 1, 8)];
                let features = neighbour_max_product_relu(&concat_product(&a, &b, &theta), &graph, &phi);
                let expected = two_layers(&features, first, second);
                let result = scored_dev_conv([&a, &b], &graph, [&theta, &phi], [first, second]);
                assert_close(result.data(), expected.data(), 1e-5);
            }
        });
    }
}
