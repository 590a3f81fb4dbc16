//! Dot products along the edges of a graph, and the softmax over each row of them: attention, Eq. (2).

use super::isa::{Isa, NARROW, RowKernel, fused};
use super::{Csr, Matrix};
use rayon::prelude::*;
use std::ops::Range;

/// Computes `<q_i, k_j>` for every entry (i, j) of the graph.
///
/// # Shapes
/// - `q`: n_rows x width, `k`: n_cols x width
/// - returns one value per entry of `graph`
///
/// # Panics
/// When the shapes do not match.
///
/// ```
/// use neural_mesh::linalg::{Csr, Matrix, neighbour_dots};
/// let (q, k) = (Matrix::new(2, 1, vec![2.0, 3.0]), Matrix::new(2, 1, vec![5.0, 7.0]));
/// assert_eq!(neighbour_dots(&q, &k, &Csr::from_edges(2, [[0, 1]])), [14.0, 15.0]);
/// ```
pub fn neighbour_dots(q: &Matrix, k: &Matrix, graph: &Csr) -> Vec<f32> {
    dots_on(Isa::best(), q, k, graph)
}

fn dots_on(isa: Isa, q: &Matrix, k: &Matrix, graph: &Csr) -> Vec<f32> {
    assert_eq!([graph.n_rows(), graph.n_cols()], [q.n_rows(), k.n_rows()], "one graph node per row");
    assert_eq!(q.n_cols(), k.n_cols(), "queries and keys of one width");
    isa.entries(&Dots { q, k, graph }, graph)
}

/// Derivatives of [`neighbour_dots`] to `q` and `k`.
///
/// # Panics
/// When the shapes do not match.
///
/// ```
/// use neural_mesh::linalg::{Csr, Matrix, neighbour_dots_backward};
/// let (q, k) = (Matrix::new(2, 1, vec![2.0, 3.0]), Matrix::new(2, 1, vec![5.0, 7.0]));
/// let [to_q, to_k] = neighbour_dots_backward(&q, &k, &Csr::from_edges(2, [[0, 1]]), &[1.0, 10.0]);
/// assert_eq!((to_q.data(), to_k.data()), ([7.0, 50.0].as_slice(), [30.0, 2.0].as_slice()));
/// ```
pub fn neighbour_dots_backward(q: &Matrix, k: &Matrix, graph: &Csr, gradient: &[f32]) -> [Matrix; 2] {
    assert_eq!(gradient.len(), graph.n_entries(), "one gradient per entry");
    let isa = Isa::best();
    let (incoming, origin) = graph.transposed();
    let incoming_gradient: Vec<f32> = origin.iter().map(|&at| gradient[at as usize]).collect();
    let to_q = WeightedRows { graph, weights: gradient, rows_of: k };
    let to_k = WeightedRows { graph: &incoming, weights: &incoming_gradient, rows_of: q };
    [isa.matrix(&to_q, q.n_rows(), q.n_cols()), isa.matrix(&to_k, k.n_rows(), k.n_cols())]
}

/// Computes the softmax of `values` over each row of the graph: positive, each row summing to 1.
///
/// # Shapes
/// - `values` and the result: one per entry of `graph`
///
/// # Panics
/// When the shapes do not match.
///
/// ```
/// use neural_mesh::linalg::{Csr, neighbour_softmax};
/// let star = Csr::from_edges(3, [[0, 1], [0, 2]]);
/// assert_eq!(neighbour_softmax(&[5.0, 5.0, 1.0, -3.0], &star), [0.5, 0.5, 1.0, 1.0]);
/// ```
pub fn neighbour_softmax(values: &[f32], graph: &Csr) -> Vec<f32> {
    assert_eq!(values.len(), graph.n_entries(), "one value per entry");
    Isa::best().entries(&Softmax { values, graph }, graph)
}

/// Derivative of [`neighbour_softmax`] to its values, from its result.
///
/// # Panics
/// When the shapes do not match.
///
/// ```
/// use neural_mesh::linalg::{Csr, neighbour_softmax_backward};
/// let row = Csr::from_entries(1, 2, [[0, 0], [0, 1]].into_iter());
/// assert_eq!(neighbour_softmax_backward(&[0.5, 0.5], &row, &[1.0, 0.0]), [0.25, -0.25]);
/// ```
pub fn neighbour_softmax_backward(softmax: &[f32], graph: &Csr, gradient: &[f32]) -> Vec<f32> {
    assert_eq!([softmax.len(), gradient.len()], [graph.n_entries(); 2], "one value per entry");
    let row_backward = |row: usize| {
        let (softmax, gradient) = (&softmax[graph.range(row)], &gradient[graph.range(row)]);
        let mean: f32 = softmax.iter().zip(gradient).map(|(s, g)| s * g).sum();
        softmax.iter().zip(gradient).map(move |(s, g)| s * (g - mean))
    };
    (0..graph.n_rows()).into_par_iter().flat_map_iter(row_backward).collect()
}

struct Dots<'a> {
    q: &'a Matrix,
    k: &'a Matrix,
    graph: &'a Csr,
}

impl RowKernel for Dots<'_> {
    #[inline(always)]
    fn compute<const FMA: bool>(&self, rows: Range<usize>, out: &mut [f32]) {
        let start = self.graph.range_of_rows(rows.clone()).start;
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
            *sum = fused::<FMA>(*a, *b, *sum);
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
        let start = self.graph.range_of_rows(rows.clone()).start;
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

/// `y_i = sum over entries (i, j) of weight_ij * row_j`.
struct WeightedRows<'a> {
    graph: &'a Csr,
    weights: &'a [f32],
    rows_of: &'a Matrix,
}

impl RowKernel for WeightedRows<'_> {
    #[inline(always)]
    fn compute<const FMA: bool>(&self, rows: Range<usize>, out: &mut [f32]) {
        for (i, out) in rows.zip(out.chunks_exact_mut(self.rows_of.n_cols().max(1))) {
            for (weight, &j) in self.weights[self.graph.range(i)].iter().zip(self.graph.row(i)) {
                for (y, x) in out.iter_mut().zip(self.rows_of.row(j as usize)) {
                    *y = fused::<FMA>(*weight, *x, *y);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_values::{assert_close, ragged_graph, random};
    use super::*;

    #[test]
    fn every_instruction_set_agrees_with_naive_dots() {
        for isa in Isa::available() {
            for [n, width] in [[0, 3], [80, 64], [150, 21]] {
                let (q, k, graph) = (random(n, width, 1), random(n, width, 2), ragged_graph(n));
                let naive = graph
                    .entries()
                    .map(|[i, j]| q.row(i as usize).iter().zip(k.row(j as usize)).map(|(a, b)| a * b).sum::<f32>());
                assert_close(&dots_on(isa, &q, &k, &graph), &naive.collect::<Vec<_>>(), 1e-5);
            }
        }
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
}
