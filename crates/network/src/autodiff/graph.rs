//! Operations along the edges of a graph (its entries); a value per entry is a column, n_entries x 1.

use super::dense::{entrywise, rows, stacked_weights_backward};
use super::{Tape, Value};
use crate::linalg::{self, Csr, Matrix};
use std::sync::Arc;

impl Tape {
    /// Computes `max(y w, 0)` with `y_i = max_j (u_i - u_j)` over the neighbours j.
    pub fn neighbour_max_product_relu(&mut self, u: &Value, graph: &Arc<Csr>, weights: &Value) -> Value {
        let result = Arc::new(linalg::neighbour_max_product_relu(&u.matrix, graph, &weights.matrix));
        let (u_kept, weights_kept, active, graph) =
            (u.matrix.clone(), weights.matrix.clone(), result.clone(), graph.clone());
        self.record(result, [u, weights], move |gradient, [to_u, to_weights]| {
            let gradient = entrywise(gradient, &active, |g, y| if y > 0.0 { g } else { 0.0 });
            let to_largest = || linalg::product_input_backward(&gradient, &weights_kept);
            [
                to_u.then(|| linalg::neighbour_max_backward(&u_kept, &graph, &to_largest())),
                to_weights
                    .then(|| linalg::product_weights_backward(&linalg::neighbour_max(&u_kept, &graph), &gradient)),
            ]
        })
    }

    /// Chains [`Tape::concat_product`], [`Tape::neighbour_max_product_relu`] and [`Tape::two_layers`] without storing
    /// intermediate values.
    pub fn scored_dev_conv(
        &mut self,
        [a, b]: [&Value; 2],
        graph: &Arc<Csr>,
        [theta, phi]: [&Value; 2],
        [first, second]: [[&Value; 2]; 2],
    ) -> Value {
        let layers = [first, second].map(|layer| layer.map(Value::matrix));
        let result = linalg::scored_dev_conv([a, b].map(Value::matrix), graph, [theta, phi].map(Value::matrix), layers);
        let inputs = [a, b, theta, phi, first[0], first[1], second[0], second[1]];
        let (kept, graph) = (inputs.map(|input| input.matrix.clone()), graph.clone());
        self.record(result, inputs, move |gradient, needed| {
            // A second tape repeats the chain, with parameters where a gradient is needed.
            let mut tape = Tape::default();
            let mut again = |i: usize| match needed[i] {
                true => tape.parameter(kept[i].clone()),
                false => Value::constant(kept[i].clone()),
            };
            let values: [Value; 8] = std::array::from_fn(&mut again);
            let [a, b, theta, phi, w, bias, last_w, last_bias] = &values;
            let mapped = tape.concat_product(a, b, theta);
            let features = tape.neighbour_max_product_relu(&mapped, &graph, phi);
            let result = tape.two_layers(&features, [w, bias], [last_w, last_bias]);
            let gradients = tape.backward(&[(&result, gradient.clone())]);
            values.each_ref().map(|value| gradients.get(value).cloned())
        })
    }

    /// Computes `-|q_i - k_j|^2 / 2` for every entry (i, j).
    pub fn neighbour_closeness(&mut self, q: &Value, k: &Value, graph: &Arc<Csr>) -> Value {
        let result = column(closeness(&q.matrix, &k.matrix, graph));
        let (q_kept, k_kept, graph) = (q.matrix.clone(), k.matrix.clone(), graph.clone());
        self.record(result, [q, k], move |gradient, _| {
            // The derivative to q_i is the sum of g (k_j - q_i) over the entries (i, j), and to k_j the sum of g (q_i - k_j).
            let [mut to_q, mut to_k] = linalg::neighbour_dots_backward(&q_kept, &k_kept, &graph, gradient.data());
            let (mut of_rows, mut of_columns) = (vec![0.0; graph.n_rows()], vec![0.0; graph.n_rows()]);
            for ([i, j], g) in graph.entries().zip(gradient.data()) {
                of_rows[i as usize] += g;
                of_columns[j as usize] += g;
            }
            subtract_rows(&mut to_q, &q_kept, &of_rows);
            subtract_rows(&mut to_k, &k_kept, &of_columns);
            [Some(to_q), Some(to_k)]
        })
    }

    /// Computes the softmax over each row of the graph: n_entries x 1 to n_entries x 1.
    pub fn neighbour_softmax(&mut self, x: &Value, graph: &Arc<Csr>) -> Value {
        let result = Arc::new(column(linalg::neighbour_softmax(x.matrix.data(), graph)));
        let (kept, graph) = (result.clone(), graph.clone());
        self.record(result, [x], move |gradient, _| {
            [Some(column(linalg::neighbour_softmax_backward(kept.data(), &graph, gradient.data())))]
        })
    }

    /// Sums `weight * row of x` over the entries of each graph row: n_entries x n_cols to n_rows x n_cols.
    pub fn entry_sums(&mut self, weights: &Value, x: &Value, graph: &Arc<Csr>) -> Value {
        let result = entry_sums(weights.matrix.data(), &x.matrix, graph);
        let (weights_kept, x_kept, graph) = (weights.matrix.clone(), x.matrix.clone(), graph.clone());
        self.record(result, [weights, x], move |gradient, _| {
            let mut to_weights = vec![0.0; graph.n_entries()];
            let mut to_x = Matrix::zeros(graph.n_entries(), gradient.n_cols());
            let columns = gradient.n_cols().max(1);
            for row in 0..graph.n_rows() {
                for at in graph.range(row) {
                    let products = gradient.row(row).iter().zip(x_kept.row(at));
                    to_weights[at] = products.map(|(g, x)| g * x).sum();
                    let to_entry = to_x.data_mut()[at * columns..].iter_mut().zip(gradient.row(row));
                    to_entry.for_each(|(to, g)| *to = g * weights_kept.data()[at]);
                }
            }
            [Some(column(to_weights)), Some(to_x)]
        })
    }

    /// Computes `S A S^T` on the entries of `graph`, which are also those of S.
    pub fn sparse_product(&mut self, s: &Value, graph: &Arc<Csr>, adjacency: &Arc<Csr>) -> Value {
        let result = column(linalg::sparse_product(s.matrix.data(), graph, adjacency));
        let (s_kept, graph, adjacency) = (s.matrix.clone(), graph.clone(), adjacency.clone());
        self.record(result, [s], move |gradient, _| {
            [Some(column(linalg::sparse_product_backward(s_kept.data(), &graph, &adjacency, gradient.data())))]
        })
    }

    /// Computes `y w + m output_bias` with `y_n = sum_k max(u_n - u_k + bias, 0)` over the m neighbours k.
    pub fn pair_relu_product(
        &mut self,
        [u, bias]: [&Value; 2],
        graph: &Arc<Csr>,
        [weights, output_bias]: [&Value; 2],
    ) -> Value {
        let nothing = Value::constant(Matrix::zeros(u.matrix.n_rows(), 0));
        self.concat_pair_relu_product(&nothing, [u, bias], graph, [weights, output_bias])
    }

    /// Computes `[x | y] w + m output_bias` with y and m of [`Tape::pair_relu_product`].
    pub fn concat_pair_relu_product(
        &mut self,
        x: &Value,
        [u, bias]: [&Value; 2],
        graph: &Arc<Csr>,
        [weights, output_bias]: [&Value; 2],
    ) -> Value {
        let layer = [weights, output_bias].map(Value::matrix);
        let result = linalg::concat_pair_relu_product(&x.matrix, &u.matrix, bias.matrix.data(), graph, layer);
        let [x_kept, u_kept, bias_kept, weights_kept] = [x, u, bias, weights].map(|value| value.matrix.clone());
        let graph = graph.clone();
        let inputs = [x, u, bias, weights, output_bias];
        self.record(result, inputs, move |gradient, [to_x, _, _, to_weights, to_output_bias]| {
            let n_left = x_kept.n_cols();
            let to_sums = linalg::product_input_backward(gradient, &rows(&weights_kept, n_left..weights_kept.n_rows()));
            let inner = linalg::pair_relu_backward(&u_kept, bias_kept.data(), &graph, &to_sums);
            let sums = || linalg::pair_relu(&u_kept, bias_kept.data(), &graph);
            let n_neighbours = || column((0..graph.n_rows()).map(|n| graph.row(n).len() as f32).collect());
            [
                to_x.then(|| linalg::product_input_backward(gradient, &rows(&weights_kept, 0..n_left))),
                Some(inner.u),
                Some(inner.bias),
                to_weights.then(|| stacked_weights_backward([&x_kept, &sums()], gradient)),
                to_output_bias.then(|| linalg::product_weights_backward(&n_neighbours(), gradient)),
            ]
        })
    }
}

fn entry_sums(weights: &[f32], x: &Matrix, graph: &Csr) -> Matrix {
    assert_eq!([weights.len(), x.n_rows()], [graph.n_entries(); 2], "a weight and a row for each entry");
    let mut sums = Matrix::zeros(graph.n_rows(), x.n_cols());
    for row in 0..graph.n_rows() {
        for at in graph.range(row) {
            let sum = sums.data_mut()[row * x.n_cols()..].iter_mut().zip(x.row(at));
            sum.for_each(|(sum, x)| *sum += weights[at] * x);
        }
    }
    sums
}

fn closeness(q: &Matrix, k: &Matrix, graph: &Csr) -> Vec<f32> {
    let half = |m: &Matrix| -> Vec<f32> {
        (0..m.n_rows()).map(|row| 0.5 * m.row(row).iter().map(|x| x * x).sum::<f32>()).collect()
    };
    let (of_q, of_k) = (half(q), half(k));
    let mut values = linalg::neighbour_dots(q, k, graph);
    for (value, [i, j]) in values.iter_mut().zip(graph.entries()) {
        *value -= of_q[i as usize] + of_k[j as usize];
    }
    values
}

fn subtract_rows(to: &mut Matrix, from: &Matrix, factors: &[f32]) {
    let n_cols = from.n_cols().max(1);
    let rows = to.data_mut().chunks_exact_mut(n_cols).zip(from.data().chunks_exact(n_cols));
    for ((to, from), factor) in rows.zip(factors) {
        to.iter_mut().zip(from).for_each(|(to, from)| *to -= factor * from);
    }
}

fn column(values: Vec<f32>) -> Matrix {
    Matrix::new(values.len(), 1, values)
}

#[cfg(test)]
mod tests {
    use super::super::test_gradients::check_gradients;
    use super::*;
    use crate::linalg::test_values::{ragged_graph, random};

    fn symmetric_graph(n: usize) -> Arc<Csr> {
        let entries: Vec<_> = ragged_graph(n).entries().collect();
        Csr::from_edges(n, entries).into()
    }

    #[test]
    fn gradients_of_dev_conv_and_tri_conv_kernels() {
        let graph = Arc::new(ragged_graph(25));
        let inputs = [random(25, 6, 1), random(1, 6, 2), random(6, 5, 3), random(1, 5, 4)];
        check_gradients(&inputs, |tape, v| tape.neighbour_max_product_relu(&v[0], &graph, &v[2]));
        check_gradients(&inputs, |tape, v| tape.pair_relu_product([&v[0], &v[1]], &graph, [&v[2], &v[3]]));
        let beside = [random(25, 6, 1), random(1, 6, 2), random(8, 5, 3), random(1, 5, 4), random(25, 2, 5)];
        check_gradients(&beside, |tape, v| {
            tape.concat_pair_relu_product(&v[4], [&v[0], &v[1]], &graph, [&v[2], &v[3]])
        });
        let inputs = [random(25, 3, 1), random(25, 3, 2), random(6, 5, 3), random(5, 4, 4), random(4, 4, 5)];
        let inputs = [&inputs[..], &[random(1, 4, 6), random(4, 1, 7), random(1, 1, 8)]].concat();
        check_gradients(&inputs, |tape, v| {
            tape.scored_dev_conv([&v[0], &v[1]], &graph, [&v[2], &v[3]], [[&v[4], &v[5]], [&v[6], &v[7]]])
        });
    }

    #[test]
    fn gradients_of_attention() {
        let graph = Arc::new(ragged_graph(25));
        let values = [random(graph.n_entries(), 1, 1)];
        check_gradients(&values, |tape, v| tape.neighbour_softmax(&v[0], &graph));
        check_gradients(&[random(25, 6, 1), random(25, 6, 2)], |tape, v| {
            tape.neighbour_closeness(&v[0], &v[1], &graph)
        });
        let inputs = [random(graph.n_entries(), 1, 1), random(graph.n_entries(), 3, 2)];
        check_gradients(&inputs, |tape, v| tape.entry_sums(&v[0], &v[1], &graph));
    }

    #[test]
    fn sums_over_entries_have_their_golden_values() {
        let graph = Arc::new(Csr::from_entries(3, 9, [[0, 4], [0, 8], [2, 1]].into_iter()));
        let [weights, x] =
            [Matrix::new(3, 1, vec![1.0, -2.0, 0.5]), Matrix::new(3, 2, vec![1.0, 2.0, 3.0, 4.0, 6.0, 8.0])];
        let sums = Tape::default().entry_sums(&Value::constant(weights), &Value::constant(x), &graph);
        assert_eq!(sums.matrix(), &Matrix::new(3, 2, vec![-5.0, -6.0, 0.0, 0.0, 3.0, 4.0]));
    }

    #[test]
    fn gradients_of_the_sparse_product() {
        let (graph, adjacency) = (symmetric_graph(25), Csr::from_edges(25, [[0, 1], [1, 7], [3, 20], [8, 9], [1, 3]]));
        let adjacency = Arc::new(adjacency);
        check_gradients(&[random(graph.n_entries(), 1, 1)], |tape, v| tape.sparse_product(&v[0], &graph, &adjacency));
    }
}
