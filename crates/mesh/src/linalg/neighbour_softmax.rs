//! Attention, Eq. (2).

use super::isa::{ColumnKernel, Isa, NARROW, RowKernel, multiply_add};
use super::{Csr, Matrix};
use std::ops::Range;

/// Computes `<q_i, k_j>` for every entry (i, j) of the graph.
///
/// # Shapes
/// - `q`: n_rows x width, `k`: n_cols x width
/// - returns one value per entry of `graph`
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::{Csr, Matrix, neighbour_dots};
/// let (q, k) = (Matrix::new(2, 1, vec![2.0, 3.0]), Matrix::new(2, 1, vec![5.0, 7.0]));
/// assert_eq!(neighbour_dots(&q, &k, &Csr::from_edges(2, [[0, 1]])), [14.0, 15.0]);
/// ```
pub fn neighbour_dots(q: &Matrix, k: &Matrix, graph: &Csr) -> Vec<f32> {
    assert_eq!([graph.n_rows(), graph.n_cols()], [q.n_rows(), k.n_rows()], "one graph node per row");
    assert_eq!(q.n_cols(), k.n_cols(), "queries and keys of one width");
    Isa::best().compute_entries(&Dots { q, k, graph }, graph)
}

/// Computes the derivatives of [`neighbour_dots`] to `q` and `k`.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::{Csr, Matrix, neighbour_dots_backward};
/// let (q, k) = (Matrix::new(2, 1, vec![2.0, 3.0]), Matrix::new(2, 1, vec![5.0, 7.0]));
/// let [to_q, to_k] = neighbour_dots_backward(&q, &k, &Csr::from_edges(2, [[0, 1]]), &[1.0, 10.0]);
/// assert_eq!((to_q.data(), to_k.data()), ([7.0, 50.0].as_slice(), [30.0, 2.0].as_slice()));
/// ```
pub fn neighbour_dots_backward(q: &Matrix, k: &Matrix, graph: &Csr, gradient: &[f32]) -> [Matrix; 2] {
    assert_eq!([graph.n_rows(), graph.n_cols()], [q.n_rows(), k.n_rows()], "one graph node per row");
    assert_eq!(gradient.len(), graph.n_entries(), "one gradient per entry");
    let (incoming, origin) = graph.transpose();
    let incoming_gradient: Vec<f32> = origin.iter().map(|&at| gradient[at as usize]).collect();
    let to_q = WeightedRows { graph, weights: gradient, rows_of: k };
    let to_k = WeightedRows { graph: &incoming, weights: &incoming_gradient, rows_of: q };
    let isa = Isa::best();
    [isa.compute_matrix(&to_q, q.n_rows(), q.n_cols()), isa.compute_matrix(&to_k, k.n_rows(), k.n_cols())]
}

/// Computes the softmax over each row of the graph, with one value per entry.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::{Csr, neighbour_softmax};
/// let star = Csr::from_edges(3, [[0, 1], [0, 2]]);
/// assert_eq!(neighbour_softmax(&[5.0, 5.0, 1.0, -3.0], &star), [0.5, 0.5, 1.0, 1.0]);
/// ```
pub fn neighbour_softmax(values: &[f32], graph: &Csr) -> Vec<f32> {
    assert_eq!(values.len(), graph.n_entries(), "one value per entry");
    Isa::best().compute_entries(&Softmax { values, graph }, graph)
}

/// Computes the derivative of [`neighbour_softmax`] to its values, from its result.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::{Csr, neighbour_softmax_backward};
/// let row = Csr::from_entries(1, 2, [[0, 0], [0, 1]].into_iter());
/// assert_eq!(neighbour_softmax_backward(&[0.5, 0.5], &row, &[1.0, 0.0]), [0.25, -0.25]);
/// ```
pub fn neighbour_softmax_backward(softmax: &[f32], graph: &Csr, gradient: &[f32]) -> Vec<f32> {
    assert_eq!([softmax.len(), gradient.len()], [graph.n_entries(); 2], "one value per entry");
    Isa::best().compute_entries(&SoftmaxBackward { softmax, graph, gradient }, graph)
}

struct Dots<'a> {
    q: &'a Matrix,
    k: &'a Matrix,
    graph: &'a Csr,
}

impl RowKernel for Dots<'_> {
    #[inline(always)]
    fn compute<const FMA: bool>(&self, rows: Range<usize>, out: &mut [f32]) {
        let start = self.graph.rows_range(rows.clone()).start;
        for i in rows {
            let q = self.q.row(i);
            for (at, &j) in self.graph.range(i).zip(self.graph.row(i)) {
                out[at - start] = dot::<FMA>(q, self.k.row(j as usize));
            }
        }
    }
}

#[inline(always)]
fn dot<const FMA: bool>(a: &[f32], b: &[f32]) -> f32 {
    let mut sums = [0.0f32; NARROW];
    let (a_chunks, b_chunks) = (a.chunks_exact(NARROW), b.chunks_exact(NARROW));
    let rest: f32 = a_chunks.remainder().iter().zip(b_chunks.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a_chunks.zip(b_chunks) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum = multiply_add::<FMA>(*a, *b, *sum);
        }
    }
    sums.iter().sum::<f32>() + rest
}

struct Softmax<'a> {
    values: &'a [f32],
    graph: &'a Csr,
}

impl RowKernel for Softmax<'_> {
    #[inline(always)]
    fn compute<const FMA: bool>(&self, rows: Range<usize>, out: &mut [f32]) {
        let start = self.graph.rows_range(rows.clone()).start;
        for i in rows {
            let range = self.graph.range(i);
            let values = &self.values[range.clone()];
            let out = &mut out[range.start - start..range.end - start];
            let largest = values.iter().copied().fold(f32::NEG_INFINITY, f32::max);
            out.iter_mut().zip(values).for_each(|(y, x)| *y = (x - largest).exp());
            let scale = 1.0 / out.iter().sum::<f32>();
            out.iter_mut().for_each(|y| *y *= scale);
        }
    }
}

/// The kernel `y_i = sum_j weight_ij row_j`.
struct WeightedRows<'a> {
    graph: &'a Csr,
    weights: &'a [f32],
    rows_of: &'a Matrix,
}

impl ColumnKernel for WeightedRows<'_> {
    fn width(&self) -> usize {
        self.rows_of.n_cols()
    }

    #[inline(always)]
    fn columns<const COLS: usize, const FMA: bool>(&self, i: usize, col: usize, out: &mut [f32; COLS]) {
        let mut sums = [0.0f32; COLS];
        for (weight, &j) in self.weights[self.graph.range(i)].iter().zip(self.graph.row(i)) {
            let row = self.rows_of.window::<COLS>(j as usize, col);
            for c in 0..COLS {
                sums[c] = multiply_add::<FMA>(*weight, row[c], sums[c]);
            }
        }
        *out = sums;
    }
}

struct SoftmaxBackward<'a> {
    softmax: &'a [f32],
    graph: &'a Csr,
    gradient: &'a [f32],
}

impl RowKernel for SoftmaxBackward<'_> {
    #[inline(always)]
    fn compute<const FMA: bool>(&self, rows: Range<usize>, out: &mut [f32]) {
        let start = self.graph.rows_range(rows.clone()).start;
        for range in rows.map(|row| self.graph.range(row)) {
            let (softmax, gradient) = (&self.softmax[range.clone()], &self.gradient[range.clone()]);
            let mean: f32 = softmax.iter().zip(gradient).map(|(s, g)| s * g).sum();
            let out = &mut out[range.start - start..range.end - start];
            out.iter_mut().zip(softmax.iter().zip(gradient)).for_each(|(out, (s, g))| *out = s * (g - mean));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_values::{assert_close, assert_slopes, ragged_graph, random};
    use super::*;

    #[test]
    fn every_instruction_set_agrees_with_naive_dots() {
        Isa::on_each(|| {
            for [n, width] in [[0, 3], [80, 64], [150, 21]] {
                let (q, k, graph) = (random(n, width, 1), random(n, width, 2), ragged_graph(n));
                let naive = graph
                    .entries()
                    .map(|[i, j]| q.row(i as usize).iter().zip(k.row(j as usize)).map(|(a, b)| a * b).sum::<f32>());
                assert_close(&neighbour_dots(&q, &k, &graph), &naive.collect::<Vec<_>>(), 1e-5);
            }
        });
    }

    #[test]
    fn softmax_agrees_with_its_definition_and_stays_finite() {
        let graph = ragged_graph(90);
        let values = random(1, graph.n_entries(), 3).into_data();
        let softmax = neighbour_softmax(&values, &graph);
        for [i, j] in graph.entries() {
            let at = graph.position(i as usize, j).unwrap();
            let sum: f32 = values[graph.range(i as usize)].iter().map(|x| x.exp()).sum();
            assert_close(&[softmax[at]], &[values[at].exp() / sum], 1e-6);
        }
        let huge: Vec<f32> = values.iter().map(|x| x * 1e30).collect();
        assert!(neighbour_softmax(&huge, &graph).iter().all(|s| (0.0..=1.0).contains(s)));
    }

    fn naive_dots_backward(q: &Matrix, k: &Matrix, graph: &Csr, gradient: &[f32]) -> [Matrix; 2] {
        let width = q.n_cols();
        let mut to = [Matrix::zeros(q.n_rows(), width), Matrix::zeros(k.n_rows(), width)];
        for ([i, j], g) in graph.entries().map(|pair| pair.map(|row| row as usize)).zip(gradient) {
            for c in 0..width {
                to[0].data_mut()[i * width + c] += g * k.row(j)[c];
                to[1].data_mut()[j * width + c] += g * q.row(i)[c];
            }
        }
        to
    }

    #[test]
    fn every_instruction_set_agrees_with_the_naive_derivative_of_dots() {
        Isa::on_each(|| {
            for [n, width] in [[0, 3], [80, 64], [150, 21]] {
                let (q, k, graph) = (random(n, width, 1), random(n, width, 2), ragged_graph(n));
                let gradient = random(graph.n_entries(), 1, 3).into_data();
                let expected = naive_dots_backward(&q, &k, &graph, &gradient);
                let found = neighbour_dots_backward(&q, &k, &graph, &gradient);
                found.iter().zip(&expected).for_each(|(a, b)| assert_close(a.data(), b.data(), 1e-5));
            }
        });
    }

    #[test]
    fn gradients_of_dots_are_slopes_in_double_precision() {
        let (q, k, graph) = (random(20, 3, 1), random(20, 3, 2), ragged_graph(20));
        let gradient = random(graph.n_entries(), 1, 3).into_data();
        let [to_q, to_k] = neighbour_dots_backward(&q, &k, &graph, &gradient);
        assert_slopes(&[to_q.data(), to_k.data()].concat(), &[q.data(), k.data()].concat(), |x| {
            let dot =
                |[i, j]: [u32; 2]| (0..3).map(|c| x[i as usize * 3 + c] * x[60 + j as usize * 3 + c]).sum::<f64>();
            graph.entries().zip(&gradient).map(|(pair, g)| f64::from(*g) * dot(pair)).sum()
        });
    }

    #[test]
    fn gradients_of_the_softmax_are_slopes_in_double_precision() {
        let graph = ragged_graph(30);
        let [values, gradient] = [3, 4].map(|seed| random(1, graph.n_entries(), seed).into_data());
        let softmax = neighbour_softmax(&values, &graph);
        assert_slopes(&neighbour_softmax_backward(&softmax, &graph, &gradient), &values, |x| {
            let row = |i: usize| {
                let sum: f64 = x[graph.range(i)].iter().map(|x| x.exp()).sum();
                graph.range(i).map(|at| f64::from(gradient[at]) * x[at].exp() / sum).sum::<f64>()
            };
            (0..30).map(row).sum()
        });
    }
}
