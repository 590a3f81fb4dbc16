//! `S A S^T` on a fixed pattern, Eq. (3).

use std::sync::{Mutex, PoisonError};

use super::Csr;
use crate::parallel;

/// Computes `A_s[i, j] = sum_{k, l} S[i, k] A[k, l] S[j, l]` for every entry (i, j) of `graph`.
///
/// # Shapes
/// - `graph`: the pattern of S and of the result, symmetric, n x n
/// - `s` and the result: one value per entry of `graph`
/// - `adjacency`: A, zeros and ones, symmetric, n x n
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::{Csr, sparse_product};
/// let edge = Csr::from_edges(2, [[0, 1]]);
/// // Each node looks at the other only, so the edge carries over.
/// assert_eq!(sparse_product(&[1.0, 1.0], &edge, &edge), [1.0, 1.0]);
/// ```
pub fn sparse_product(s: &[f32], graph: &Csr, adjacency: &Csr) -> Vec<f32> {
    check_shapes(s, graph, adjacency);
    let mut values = upper_half(s, graph, adjacency);
    for row in 0..graph.n_rows() {
        for (at, &col) in graph.range(row).zip(graph.row(row)).take_while(|(_, col)| (**col as usize) < row) {
            if let Some(mirror) = graph.position(col as usize, row as u32) {
                values[at] = values[mirror];
            }
        }
    }
    values
}

/// Computes the derivative of [`sparse_product`] to the values of S.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::{Csr, sparse_product_backward};
/// let edge = Csr::from_edges(2, [[0, 1]]);
/// // Both entries of the result are S[0, 1] S[1, 0].
/// assert_eq!(sparse_product_backward(&[0.5, 1.0], &edge, &edge, &[1.0, 1.0]), [2.0, 1.0]);
/// ```
pub fn sparse_product_backward(s: &[f32], graph: &Csr, adjacency: &Csr, gradient: &[f32]) -> Vec<f32> {
    check_shapes(s, graph, adjacency);
    assert_eq!(gradient.len(), graph.n_entries(), "one gradient per entry");
    compute_rows(graph, |scratch, row, out| {
        let pair_gradient = |at: usize, j: u32| {
            gradient[at] + graph.position(j as usize, row as u32).map_or(0.0, |mirror| gradient[mirror])
        };
        for (at, &j) in graph.range(row).zip(graph.row(row)) {
            let weight = pair_gradient(at, j);
            for (s, &l) in s[graph.range(j as usize)].iter().zip(graph.row(j as usize)) {
                scratch.add(l, weight * s);
            }
        }
        for (out, &k) in out.iter_mut().zip(graph.row(row)) {
            *out = adjacency.row(k as usize).iter().map(|&l| scratch.sums[l as usize]).sum();
        }
    })
}

fn check_shapes(s: &[f32], graph: &Csr, adjacency: &Csr) {
    assert_eq!(s.len(), graph.n_entries(), "one value per entry");
    assert_eq!(graph.n_rows(), adjacency.n_rows(), "two graphs over the same nodes");
    debug_assert!(graph.is_symmetric() && adjacency.is_symmetric(), "symmetric graphs");
}

fn upper_half(s: &[f32], graph: &Csr, adjacency: &Csr) -> Vec<f32> {
    compute_rows(graph, |scratch, row, out| {
        for (s, &k) in s[graph.range(row)].iter().zip(graph.row(row)) {
            for &l in adjacency.row(k as usize) {
                scratch.add(l, *s);
            }
        }
        for (out, &j) in out.iter_mut().zip(graph.row(row)).filter(|(_, j)| **j as usize >= row) {
            let entries = s[graph.range(j as usize)].iter().zip(graph.row(j as usize));
            *out = entries.map(|(s, &l)| s * scratch.sums[l as usize]).sum();
        }
    })
}

struct Scratch {
    sums: Vec<f32>,
    touched: Vec<u32>,
}

impl Scratch {
    #[inline]
    fn add(&mut self, col: u32, value: f32) {
        self.sums[col as usize] += value;
        self.touched.push(col);
    }

    fn clear(&mut self) {
        for col in self.touched.drain(..) {
            self.sums[col as usize] = 0.0;
        }
    }
}

const BLOCK: usize = 256;

fn compute_rows(graph: &Csr, row_values: impl Fn(&mut Scratch, usize, &mut [f32]) + Sync) -> Vec<f32> {
    let mut values = vec![0.0; graph.n_entries()];
    let blocks = graph.split_rows(BLOCK, &mut values);
    // Sums of a whole row are zero again after it, so one for each thread at work will do.
    let idle = Mutex::new(Vec::new());
    let of_thread = || idle.lock().unwrap_or_else(PoisonError::into_inner);
    parallel::each(blocks, |(rows, out)| {
        let kept = of_thread().pop();
        let mut scratch = kept.unwrap_or_else(|| Scratch { sums: vec![0.0; graph.n_rows()], touched: Vec::new() });
        let start = graph.range(rows.start).start;
        for row in rows {
            let range = graph.range(row);
            row_values(&mut scratch, row, &mut out[range.start - start..range.end - start]);
            scratch.clear();
        }
        of_thread().push(scratch);
    });
    values
}

#[cfg(test)]
mod tests {
    use super::super::test_values::{assert_close, assert_slopes, ragged_graph, random};
    use super::*;

    fn dense(values: &[f32], graph: &Csr) -> Vec<Vec<f32>> {
        let mut rows = vec![vec![0.0; graph.n_cols()]; graph.n_rows()];
        graph.entries().zip(values).for_each(|([i, j], v)| rows[i as usize][j as usize] = *v);
        rows
    }

    #[test]
    fn a_path_with_one_original_edge_by_hand() {
        let path = Csr::from_edges(3, [[0, 1], [1, 2]]);
        let adjacency = Csr::from_edges(3, [[0, 1]]);
        // S: 0 attends to 1; 1 to 0 and 2 with 1/4 and 3/4; 2 to 1. A has only the edge 0-1: A_s[0, 1] = S[0, 1] A[1,
        // 0] S[1, 0] = 1/4 and A_s[1, 2] = S[1, 0] A[0, 1] S[2, 1] = 1/4.
        assert_eq!(sparse_product(&[1.0, 0.25, 0.75, 1.0], &path, &adjacency), [0.25; 4]);
    }

    #[test]
    fn agrees_with_dense_matrices() {
        let n = 120;
        let (graph, adjacency, s, _) = example(n);
        let result = sparse_product(&s, &graph, &adjacency);
        let (dense_s, dense_a) = (dense(&s, &graph), dense(&vec![1.0; adjacency.n_entries()], &adjacency));
        let naive = graph.entries().map(|[i, j]| {
            let row = |l: usize| (0..n).map(|k| dense_s[i as usize][k] * dense_a[k][l]).sum::<f32>();
            (0..n).map(|l| row(l) * dense_s[j as usize][l]).sum::<f32>()
        });
        let some: Vec<usize> = (0..graph.n_entries()).step_by(17).collect();
        let naive: Vec<f32> = naive.step_by(17).collect();
        assert_close(&some.iter().map(|&at| result[at]).collect::<Vec<_>>(), &naive, 1e-5);
    }

    fn example(n: usize) -> (Csr, Csr, Vec<f32>, Vec<f32>) {
        let graph = Csr::from_edges(n, ragged_graph(n).entries().collect::<Vec<_>>()).with_loops();
        let adjacency = Csr::from_edges(n, (0..n as u32 - 1).map(|i| [i, (i * i + 3) % n as u32]).collect::<Vec<_>>());
        let [s, gradient] = [1, 2].map(|seed| random(1, graph.n_entries(), seed).into_data());
        (graph, adjacency, s, gradient)
    }

    #[test]
    fn the_derivative_agrees_with_dense_matrices() {
        // With G the gradient on the pattern: (G + G') S A.
        let (graph, adjacency, s, gradient) = example(60);
        let [s_rows, g_rows] = [&s, &gradient].map(|values| dense(values, &graph));
        let a_rows = dense(&vec![1.0; adjacency.n_entries()], &adjacency);
        let product = |row: usize, col: usize| {
            let of_s = |l: usize| (0..60).map(|j| (g_rows[row][j] + g_rows[j][row]) * s_rows[j][l]).sum::<f32>();
            (0..60).map(|l| of_s(l) * a_rows[l][col]).sum::<f32>()
        };
        let naive: Vec<f32> = graph.entries().map(|[i, k]| product(i as usize, k as usize)).collect();
        assert_close(&sparse_product_backward(&s, &graph, &adjacency, &gradient), &naive, 1e-5);
    }

    #[test]
    fn gradients_are_slopes_in_double_precision() {
        let (graph, adjacency, s, gradient) = example(20);
        assert!(graph.position(3, 3).is_some());
        assert_slopes(&sparse_product_backward(&s, &graph, &adjacency, &gradient), &s, |s| {
            let entry = |i: u32, j: u32| graph.position(i as usize, j).map_or(0.0, |at| s[at]);
            let entry = |[i, j]: [u32; 2]| adjacency.entries().map(|[k, l]| entry(i, k) * entry(j, l)).sum::<f64>();
            graph.entries().zip(&gradient).map(|(pair, g)| f64::from(*g) * entry(pair)).sum()
        });
    }
}
