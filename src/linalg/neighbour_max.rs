//! The largest difference to a neighbour, column by column: `max_j (u_i - u_j) = u_i - min_j u_j`.
//!
//! The inner part of DevConv, Eq. (1), after its linear map: one product per vertex, none per edge, and exact.

use super::isa::{Isa, NARROW, RowKernel, WIDE, relu};
use super::product::multiply_rows;
use super::{Csr, Matrix};
use std::ops::Range;

/// Computes `y_i = max over neighbours j of (u_i - u_j)`; zero where a row has no neighbours.
///
/// # Shapes
/// - `u`: n x width
/// - `graph`: n rows, columns below n
/// - returns n x width
///
/// # Panics
/// When the shapes do not match.
///
/// ```
/// use neural_mesh::linalg::{Csr, Matrix, neighbour_max};
/// let u = Matrix::new(3, 1, vec![1.0, 5.0, 7.0]);
/// let path = Csr::from_edges(3, [[0, 1], [1, 2]]);
/// assert_eq!(neighbour_max(&u, &path).data(), [-4.0, 4.0, 2.0]);
/// ```
pub fn neighbour_max(u: &Matrix, graph: &Csr) -> Matrix {
    neighbour_max_on(Isa::best(), u, graph)
}

fn neighbour_max_on(isa: Isa, u: &Matrix, graph: &Csr) -> Matrix {
    assert_eq!([graph.n_rows(), graph.n_cols()], [u.n_rows(); 2], "one graph node per row");
    isa.matrix(&Forward { u, graph }, u.n_rows(), u.n_cols())
}

/// Computes `max(y w, 0)` for `y` of [`neighbour_max`], which is never held as a whole.
///
/// # Shapes
/// - `u`, `graph`: as for [`neighbour_max`]
/// - `weights`: width x n_out
/// - returns n x n_out
///
/// # Panics
/// When the shapes do not match.
///
/// ```
/// use neural_mesh::linalg::{Csr, Matrix, neighbour_max_product_relu};
/// let u = Matrix::new(3, 1, vec![1.0, 5.0, 7.0]);
/// let path = Csr::from_edges(3, [[0, 1], [1, 2]]);
/// let weights = Matrix::new(1, 2, vec![10.0, -1.0]);
/// assert_eq!(neighbour_max_product_relu(&u, &path, &weights).data(), [0.0, 4.0, 40.0, 0.0, 20.0, 0.0]);
/// ```
pub fn neighbour_max_product_relu(u: &Matrix, graph: &Csr, weights: &Matrix) -> Matrix {
    product_on(Isa::best(), u, graph, weights)
}

fn product_on(isa: Isa, u: &Matrix, graph: &Csr, weights: &Matrix) -> Matrix {
    assert_eq!([graph.n_rows(), graph.n_cols()], [u.n_rows(); 2], "one graph node per row");
    assert_eq!(u.n_cols(), weights.n_rows(), "columns of u and rows of weights");
    isa.matrix(&ForwardProduct { largest: Forward { u, graph }, weights }, u.n_rows(), weights.n_cols())
}

/// Derivative of [`neighbour_max`] to `u`: goes to `u_i` and, with a minus, to the neighbour that gave the maximum
/// (of equal ones the first).
///
/// # Panics
/// When the shapes do not match.
///
/// ```
/// use neural_mesh::linalg::{Csr, Matrix, neighbour_max_backward};
/// let (u, gradient) = (Matrix::new(2, 1, vec![1.0, 5.0]), Matrix::new(2, 1, vec![10.0, 3.0]));
/// let edge = Csr::from_edges(2, [[0, 1]]);
/// assert_eq!(neighbour_max_backward(&u, &edge, &gradient).data(), [7.0, -7.0]);
/// ```
pub fn neighbour_max_backward(u: &Matrix, graph: &Csr, gradient: &Matrix) -> Matrix {
    assert_eq!(u.shape(), gradient.shape(), "one gradient per entry");
    let isa = Isa::best();
    let winners = isa.matrix(&Winners { u, graph }, u.n_rows(), u.n_cols());
    let (incoming, _) = graph.transposed();
    let kernel = Backward { graph, incoming: &incoming, winners: &winners, gradient };
    isa.matrix(&kernel, u.n_rows(), u.n_cols())
}

struct Forward<'a> {
    u: &'a Matrix,
    graph: &'a Csr,
}

impl RowKernel for Forward<'_> {
    #[inline(always)]
    fn compute<const FMA: bool>(&self, rows: Range<usize>, out: &mut [f32]) {
        let width = self.u.n_cols();
        for (i, out) in rows.zip(out.chunks_exact_mut(width.max(1))) {
            if self.graph.row(i).is_empty() {
                continue;
            }
            let mut col = 0;
            while col + WIDE <= width {
                self.columns::<WIDE>(i, col, out);
                col += WIDE;
            }
            while col + NARROW <= width {
                self.columns::<NARROW>(i, col, out);
                col += NARROW;
            }
            for col in col..width {
                self.columns::<1>(i, col, out);
            }
        }
    }
}

impl Forward<'_> {
    #[inline(always)]
    fn columns<const COLS: usize>(&self, i: usize, col: usize, out: &mut [f32]) {
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
        let out = &mut out[col..][..COLS];
        for c in 0..COLS {
            out[c] = own[c] - smallest[c];
        }
    }

    #[inline(always)]
    fn other<const COLS: usize>(&self, j: u32, col: usize) -> &[f32; COLS] {
        self.u.window(j as usize, col)
    }
}

struct ForwardProduct<'a> {
    largest: Forward<'a>,
    weights: &'a Matrix,
}

impl RowKernel for ForwardProduct<'_> {
    #[inline(always)]
    fn compute<const FMA: bool>(&self, rows: Range<usize>, out: &mut [f32]) {
        let mut largest = vec![0.0; rows.len() * self.weights.n_rows()];
        self.largest.compute::<FMA>(rows, &mut largest);
        multiply_rows::<FMA>(&largest, self.weights, out);
        out.iter_mut().for_each(|y| *y = relu(*y));
    }
}

/// The smaller of two numbers; a plain comparison, because `f32::min` costs more for its care of NaN. (Not for running
/// minima: there the compiler makes of it a store that may not happen, which the next load has to wait for.)
#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

/// For each entry the place of the smallest neighbour in its row of the graph, as a small whole number.
struct Winners<'a> {
    u: &'a Matrix,
    graph: &'a Csr,
}

impl RowKernel for Winners<'_> {
    #[inline(always)]
    fn compute<const FMA: bool>(&self, rows: Range<usize>, out: &mut [f32]) {
        let mut smallest = vec![0.0f32; self.u.n_cols()];
        for (i, out) in rows.zip(out.chunks_exact_mut(self.u.n_cols().max(1))) {
            smallest.fill(f32::INFINITY);
            for (place, &j) in self.graph.row(i).iter().enumerate() {
                for ((winner, min), u) in out.iter_mut().zip(&mut smallest).zip(self.u.row(j as usize)) {
                    let wins = *u < *min;
                    *winner = if wins { place as f32 } else { *winner };
                    *min = if wins { *u } else { *min };
                }
            }
        }
    }
}

struct Backward<'a> {
    graph: &'a Csr,
    incoming: &'a Csr,
    winners: &'a Matrix,
    gradient: &'a Matrix,
}

impl RowKernel for Backward<'_> {
    #[inline(always)]
    fn compute<const FMA: bool>(&self, rows: Range<usize>, out: &mut [f32]) {
        for (i, out) in rows.zip(out.chunks_exact_mut(self.gradient.n_cols().max(1))) {
            if !self.graph.row(i).is_empty() {
                out.copy_from_slice(self.gradient.row(i));
            }
            for &from in self.incoming.row(i) {
                let from = from as usize;
                let place = self.graph.row(from).partition_point(|&j| (j as usize) < i) as f32;
                let sources = self.winners.row(from).iter().zip(self.gradient.row(from));
                for (out, (winner, gradient)) in out.iter_mut().zip(sources) {
                    *out -= if *winner == place { *gradient } else { 0.0 };
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::product;
    use super::super::test_values::{assert_close, ragged_graph, random};
    use super::*;

    fn naive(u: &Matrix, graph: &Csr) -> Matrix {
        Matrix::from_fn(u.n_rows(), u.n_cols(), |i, c| {
            let differences = graph.row(i).iter().map(|&j| u.row(i)[c] - u.row(j as usize)[c]);
            differences.reduce(f32::max).unwrap_or(0.0)
        })
    }

    #[test]
    fn every_instruction_set_agrees_with_the_edge_by_edge_form() {
        for isa in Isa::available() {
            for [n, width] in [[0, 4], [1, 3], [90, 64], [200, 37]] {
                let (u, graph) = (random(n, width, 5), ragged_graph(n));
                let largest = naive(&u, &graph);
                assert_close(neighbour_max_on(isa, &u, &graph).data(), largest.data(), 1e-6);
                let weights = random(width, 20, 6);
                let expected: Vec<f32> = product(&largest, &weights, &[]).data().iter().map(|y| y.max(0.0)).collect();
                assert_close(product_on(isa, &u, &graph, &weights).data(), &expected, 1e-5);
            }
        }
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
}
