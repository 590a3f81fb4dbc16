//! Largest difference to a neighbour: the core of DevConv (Eq. 1).

use super::isa::{ColumnKernel, Isa, RowKernel, relu};
use super::product::{add_bias, multiply_rows};
use super::{Csr, Matrix};
use std::ops::Range;

/// Computes `y_i = max_j (u_i - u_j) = u_i - min_j u_j` over the neighbours j; zero without neighbours.
///
/// # Shapes
/// - `u` and the result: n x width
/// - `graph`: n x n
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::{Csr, Matrix, neighbour_max};
/// let u = Matrix::new(3, 1, vec![1.0, 5.0, 7.0]);
/// let path = Csr::from_edges(3, [[0, 1], [1, 2]]);
/// assert_eq!(neighbour_max(&u, &path).data(), [-4.0, 4.0, 2.0]);
/// ```
pub fn neighbour_max(u: &Matrix, graph: &Csr) -> Matrix {
    assert_eq!([graph.n_rows(), graph.n_cols()], [u.n_rows(); 2], "one graph node per row");
    Isa::best().compute_matrix(&NeighbourMaxKernel { u, graph }, u.n_rows(), u.n_cols())
}

/// Computes `max(y w, 0)` for `y` of [`neighbour_max`].
///
/// # Shapes
/// - `u`, `graph`: as for [`neighbour_max`]
/// - `weights`: width x n_out
/// - returns n x n_out
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::{Csr, Matrix, neighbour_max_product_relu};
/// let u = Matrix::new(3, 1, vec![1.0, 5.0, 7.0]);
/// let path = Csr::from_edges(3, [[0, 1], [1, 2]]);
/// let weights = Matrix::new(1, 2, vec![10.0, -1.0]);
/// assert_eq!(neighbour_max_product_relu(&u, &path, &weights).data(), [0.0, 4.0, 40.0, 0.0, 20.0, 0.0]);
/// ```
pub fn neighbour_max_product_relu(u: &Matrix, graph: &Csr, weights: &Matrix) -> Matrix {
    assert_eq!([graph.n_rows(), graph.n_cols()], [u.n_rows(); 2], "one graph node per row");
    assert_eq!(u.n_cols(), weights.n_rows(), "weights need as many rows as u has columns");
    Isa::best().compute_matrix(
        &NeighbourMaxProductKernel { largest: NeighbourMaxKernel { u, graph }, weights },
        u.n_rows(),
        weights.n_cols(),
    )
}

/// Computes `max(y w, 0) w' + b'` for `y` of [`neighbour_max`], without storing the features between the products.
///
/// # Shapes
/// - `u`, `graph`: as for [`neighbour_max`]
/// - `weights`: width x n_features
/// - `next`: w', n_features x n_out, and b', n_out or empty
/// - returns n x n_out
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::{Csr, Matrix, neighbour_max_two_products};
/// let number = |x: f32| Matrix::new(1, 1, vec![x]);
/// let u = Matrix::new(3, 1, vec![1.0, 5.0, 7.0]);
/// let path = Csr::from_edges(3, [[0, 1], [1, 2]]);
/// assert_eq!(neighbour_max_two_products(&u, &path, &number(10.0), (&number(2.0), &[1.0])).data(), [1.0, 81.0, 41.0]);
/// ```
pub fn neighbour_max_two_products(
    u: &Matrix,
    graph: &Csr,
    weights: &Matrix,
    (next, bias): (&Matrix, &[f32]),
) -> Matrix {
    assert_eq!([graph.n_rows(), graph.n_cols()], [u.n_rows(); 2], "one graph node per row");
    assert_eq!([u.n_cols(), weights.n_cols()], [weights.n_rows(), next.n_rows()], "sizes of the layers must match");
    assert!(bias.is_empty() || bias.len() == next.n_cols(), "one bias per column");
    let first = NeighbourMaxProductKernel { largest: NeighbourMaxKernel { u, graph }, weights };
    Isa::best().compute_matrix(&TwoProductsKernel { first, next, bias }, u.n_rows(), next.n_cols())
}

/// Computes the derivative of [`neighbour_max`] to `u`; ties go to the first neighbour.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::{Csr, Matrix, neighbour_max_backward};
/// let (u, gradient) = (Matrix::new(2, 1, vec![1.0, 5.0]), Matrix::new(2, 1, vec![10.0, 3.0]));
/// let edge = Csr::from_edges(2, [[0, 1]]);
/// assert_eq!(neighbour_max_backward(&u, &edge, &gradient).data(), [7.0, -7.0]);
/// ```
pub fn neighbour_max_backward(u: &Matrix, graph: &Csr, gradient: &Matrix) -> Matrix {
    assert_eq!([graph.n_rows(), graph.n_cols()], [u.n_rows(); 2], "one graph node per row");
    assert_eq!(u.shape(), gradient.shape(), "one gradient per entry");
    let winners = Isa::best().compute_matrix(&WinnerKernel { u, graph }, u.n_rows(), u.n_cols());
    let (incoming, origin) = graph.transpose();
    let kernel =
        NeighbourMaxBackwardKernel { graph, incoming: &incoming, origin: &origin, winners: &winners, gradient };
    Isa::best().compute_matrix(&kernel, u.n_rows(), u.n_cols())
}

struct NeighbourMaxKernel<'a> {
    u: &'a Matrix,
    graph: &'a Csr,
}

impl ColumnKernel for NeighbourMaxKernel<'_> {
    fn width(&self) -> usize {
        self.u.n_cols()
    }

    #[inline(always)]
    fn columns<const COLS: usize, const FMA: bool>(&self, i: usize, col: usize, out: &mut [f32; COLS]) {
        if self.graph.row(i).is_empty() {
            return;
        }
        let mut smallest = [f32::INFINITY; COLS];
        // Three neighbours at once: a third of the loads and stores of the minima.
        let (groups, rest) = self.graph.row(i).as_chunks();
        for &[j, k, l] in groups {
            let [j, k, l] = [self.other::<COLS>(j, col), self.other(k, col), self.other(l, col)];
            for c in 0..COLS {
                smallest[c] = smallest[c].min(smaller(j[c], smaller(k[c], l[c])));
            }
        }
        for &j in rest {
            let other = self.other::<COLS>(j, col);
            for c in 0..COLS {
                smallest[c] = smallest[c].min(other[c]);
            }
        }
        let own = self.u.window::<COLS>(i, col);
        for c in 0..COLS {
            out[c] = own[c] - smallest[c];
        }
    }
}

impl NeighbourMaxKernel<'_> {
    #[inline(always)]
    fn other<const COLS: usize>(&self, j: u32, col: usize) -> &[f32; COLS] {
        self.u.window(j as usize, col)
    }
}

struct NeighbourMaxProductKernel<'a> {
    largest: NeighbourMaxKernel<'a>,
    weights: &'a Matrix,
}

impl RowKernel for NeighbourMaxProductKernel<'_> {
    #[inline(always)]
    fn compute<const FMA: bool>(&self, rows: Range<usize>, out: &mut [f32]) {
        let mut largest = vec![0.0; rows.len() * self.weights.n_rows()];
        self.largest.compute::<FMA>(rows, &mut largest);
        multiply_rows::<FMA>(&largest, self.weights, out);
        out.iter_mut().for_each(|y| *y = relu(*y));
    }
}

struct TwoProductsKernel<'a> {
    first: NeighbourMaxProductKernel<'a>,
    next: &'a Matrix,
    bias: &'a [f32],
}

impl RowKernel for TwoProductsKernel<'_> {
    #[inline(always)]
    fn compute<const FMA: bool>(&self, rows: Range<usize>, out: &mut [f32]) {
        let mut features = vec![0.0; rows.len() * self.next.n_rows()];
        self.first.compute::<FMA>(rows, &mut features);
        multiply_rows::<FMA>(&features, self.next, out);
        add_bias(out, self.bias);
    }
}

/// Returns the smaller number; `f32::min` is slower because of NaN.
#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

struct WinnerKernel<'a> {
    u: &'a Matrix,
    graph: &'a Csr,
}

impl ColumnKernel for WinnerKernel<'_> {
    fn width(&self) -> usize {
        self.u.n_cols()
    }

    #[inline(always)]
    fn columns<const COLS: usize, const FMA: bool>(&self, i: usize, col: usize, out: &mut [f32; COLS]) {
        let mut smallest = [f32::INFINITY; COLS];
        let mut winner = [0.0f32; COLS];
        for (place, &j) in self.graph.row(i).iter().enumerate() {
            let other = self.u.window::<COLS>(j as usize, col);
            for c in 0..COLS {
                let wins = other[c] < smallest[c];
                winner[c] = if wins { place as f32 } else { winner[c] };
                smallest[c] = if wins { other[c] } else { smallest[c] };
            }
        }
        *out = winner;
    }
}

struct NeighbourMaxBackwardKernel<'a> {
    graph: &'a Csr,
    incoming: &'a Csr,
    origin: &'a [u32],
    winners: &'a Matrix,
    gradient: &'a Matrix,
}

impl ColumnKernel for NeighbourMaxBackwardKernel<'_> {
    fn width(&self) -> usize {
        self.gradient.n_cols()
    }

    #[inline(always)]
    fn columns<const COLS: usize, const FMA: bool>(&self, i: usize, col: usize, out: &mut [f32; COLS]) {
        let mut sums = [0.0f32; COLS];
        if !self.graph.row(i).is_empty() {
            sums = *self.gradient.window::<COLS>(i, col);
        }
        for (&from, &at) in self.incoming.row(i).iter().zip(&self.origin[self.incoming.range(i)]) {
            let from = from as usize;
            let place = (at as usize - self.graph.range(from).start) as f32;
            let (winner, gradient) = (self.winners.window::<COLS>(from, col), self.gradient.window::<COLS>(from, col));
            for c in 0..COLS {
                sums[c] -= if winner[c] == place { gradient[c] } else { 0.0 };
            }
        }
        *out = sums;
    }
}

#[cfg(test)]
mod tests {
    use super::super::product;
    use super::super::test_values::{assert_close, assert_slopes, ragged_graph, random};
    use super::*;

    fn naive(u: &Matrix, graph: &Csr) -> Matrix {
        Matrix::from_fn(u.n_rows(), u.n_cols(), |i, c| {
            let differences = graph.row(i).iter().map(|&j| u.row(i)[c] - u.row(j as usize)[c]);
            differences.reduce(f32::max).unwrap_or(0.0)
        })
    }

    #[test]
    fn every_instruction_set_agrees_with_the_edge_by_edge_form() {
        Isa::on_each(|| {
            for [n, width] in [[0, 4], [1, 3], [90, 64], [200, 37]] {
                let (u, graph) = (random(n, width, 5), ragged_graph(n));
                let largest = naive(&u, &graph);
                assert_close(neighbour_max(&u, &graph).data(), largest.data(), 1e-6);
                let weights = random(width, 20, 6);
                let expected: Vec<f32> = product(&largest, &weights, &[]).data().iter().map(|y| y.max(0.0)).collect();
                let features = neighbour_max_product_relu(&u, &graph, &weights);
                assert_close(features.data(), &expected, 1e-5);
                for n_out in [1, 9, 32] {
                    let (next, bias) = (random(20, n_out, 7), random(1, n_out, 8));
                    let both = neighbour_max_two_products(&u, &graph, &weights, (&next, bias.data()));
                    assert_close(both.data(), product(&features, &next, bias.data()).data(), 1e-5);
                }
            }
        });
    }

    #[test]
    fn gradients_reach_the_vertex_and_its_winning_neighbour() {
        let u = Matrix::new(3, 1, vec![1.0, 5.0, 1.0]);
        let graph = Csr::from_edges(3, [[0, 1], [1, 2]]);
        let gradient = Matrix::new(3, 1, vec![10.0, 100.0, 1000.0]);
        // Vertex 1 takes its maximum from vertex 0, the first of two equal neighbours.
        let expected = [10.0 - 100.0, 100.0 - 10.0 - 1000.0, 1000.0];
        assert_eq!(neighbour_max_backward(&u, &graph, &gradient).data(), expected);
    }

    fn naive_backward(u: &Matrix, graph: &Csr, gradient: &Matrix) -> Matrix {
        let mut to_u = Matrix::zeros(u.n_rows(), u.n_cols());
        for i in (0..u.n_rows()).filter(|&i| !graph.row(i).is_empty()) {
            for c in 0..u.n_cols() {
                let value = |j: &&u32| u.row(**j as usize)[c];
                let winner = *graph.row(i).iter().min_by(|j, k| value(j).total_cmp(&value(k))).unwrap() as usize;
                to_u.data_mut()[i * u.n_cols() + c] += gradient.row(i)[c];
                to_u.data_mut()[winner * u.n_cols() + c] -= gradient.row(i)[c];
            }
        }
        to_u
    }

    #[test]
    fn every_instruction_set_agrees_with_the_naive_derivative_also_where_neighbours_tie() {
        Isa::on_each(|| {
            for [n, width] in [[0, 4], [1, 3], [90, 64], [200, 37]] {
                let (u, graph, gradient) = (random(n, width, 5), ragged_graph(n), random(n, width, 6));
                // Few values, so that many neighbours are equal.
                let coarse = Matrix::from_fn(n, width, |i, c| (u.row(i)[c] * 2.0).round() + 0.0);
                for u in [u, coarse] {
                    let expected = naive_backward(&u, &graph, &gradient);
                    assert_close(neighbour_max_backward(&u, &graph, &gradient).data(), expected.data(), 1e-5);
                }
            }
        });
    }

    #[test]
    fn gradients_are_slopes_in_double_precision() {
        let (u, graph, gradient) = (random(25, 3, 5), ragged_graph(25), random(25, 3, 6));
        assert_slopes(neighbour_max_backward(&u, &graph, &gradient).data(), u.data(), |u| {
            let rows = (0..25).filter(|&i| !graph.row(i).is_empty());
            let entries = rows.flat_map(|i| (0..3).map(move |c| (i, c)));
            let value = |(i, c): (usize, usize)| {
                let differences = graph.row(i).iter().map(|&j| u[i * 3 + c] - u[j as usize * 3 + c]);
                f64::from(gradient.row(i)[c]) * differences.fold(f64::NEG_INFINITY, f64::max)
            };
            entries.map(value).sum()
        });
    }

    #[test]
    fn a_neighbour_named_twice_counts_once_and_one_of_many_rows_gets_from_all() {
        let twice = Csr::from_entries(3, 3, [[0, 2], [0, 2], [1, 2], [1, 2]].into_iter());
        let (u, gradient) = (Matrix::new(3, 1, vec![5.0, 6.0, 1.0]), Matrix::new(3, 1, vec![1.0, 10.0, 100.0]));
        assert_eq!(neighbour_max(&u, &twice).data(), [4.0, 5.0, 0.0]);
        assert_eq!(neighbour_max_backward(&u, &twice, &gradient).data(), [1.0, 10.0, -11.0]);
    }
}
