//! Operations on whole matrices.

use super::{Tape, Value};
use crate::linalg::{self, Matrix, concat_product, product, product_input_backward, product_weights_backward};
use std::ops::Range;
use std::sync::Arc;

impl Tape {
    /// Computes the matrix product `x w`.
    pub fn product(&mut self, x: &Value, weights: &Value) -> Value {
        let result = product(&x.matrix, &weights.matrix, &[]);
        let (x_kept, weights_kept) = (x.matrix.clone(), weights.matrix.clone());
        self.record(result, [x, weights], move |gradient, [to_x, to_weights]| {
            [
                to_x.then(|| product_input_backward(gradient, &weights_kept)),
                to_weights.then(|| product_weights_backward(&x_kept, gradient)),
            ]
        })
    }

    /// Computes `x w + bias`, with bias 1 x n_out.
    pub fn affine(&mut self, x: &Value, weights: &Value, bias: &Value) -> Value {
        let result = product(&x.matrix, &weights.matrix, bias.matrix.data());
        let (x_kept, weights_kept) = (x.matrix.clone(), weights.matrix.clone());
        self.record(result, [x, weights, bias], move |gradient, [to_x, to_weights, to_bias]| {
            [
                to_x.then(|| product_input_backward(gradient, &weights_kept)),
                to_weights.then(|| product_weights_backward(&x_kept, gradient)),
                to_bias.then(|| linalg::column_sums(gradient)),
            ]
        })
    }

    /// Computes `max(x w + b, 0) w' + b'` for two layers `[w, b]`.
    pub fn two_layers(&mut self, x: &Value, first: [&Value; 2], second: [&Value; 2]) -> Value {
        let [[w, b], [last_w, last_b]] = [first, second];
        let result = linalg::two_layers(&x.matrix, first.map(Value::matrix), second.map(Value::matrix));
        let [x_kept, w_kept, b_kept, last_kept] = [x, w, b, last_w].map(|value| value.matrix.clone());
        self.record(result, [x, w, b, last_w, last_b], move |gradient, [to_x, to_w, to_b, to_last_w, to_last_b]| {
            // The hidden layer is computed again, so the tape does not store it.
            let mut hidden = product(&x_kept, &w_kept, b_kept.data());
            hidden.data_mut().iter_mut().for_each(|y| *y = y.max(0.0));
            let to_hidden = product_input_backward(gradient, &last_kept);
            let inner = entrywise(&to_hidden, &hidden, |g, y| if y > 0.0 { g } else { 0.0 });
            [
                to_x.then(|| product_input_backward(&inner, &w_kept)),
                to_w.then(|| product_weights_backward(&x_kept, &inner)),
                to_b.then(|| linalg::column_sums(&inner)),
                to_last_w.then(|| product_weights_backward(&hidden, gradient)),
                to_last_b.then(|| linalg::column_sums(gradient)),
            ]
        })
    }

    /// Computes `[a | b] w`.
    pub fn concat_product(&mut self, a: &Value, b: &Value, weights: &Value) -> Value {
        let result = concat_product(&a.matrix, &b.matrix, &weights.matrix);
        let [a_kept, b_kept, weights_kept] = [a, b, weights].map(|value| value.matrix.clone());
        self.record(result, [a, b, weights], move |gradient, [to_a, to_b, to_weights]| {
            let n_a = a_kept.n_cols();
            [
                to_a.then(|| product_input_backward(gradient, &rows(&weights_kept, 0..n_a))),
                to_b.then(|| product_input_backward(gradient, &rows(&weights_kept, n_a..weights_kept.n_rows()))),
                to_weights.then(|| stacked_weights_backward([&a_kept, &b_kept], gradient)),
            ]
        })
    }

    /// Adds a row, 1 x n_cols, to every row of x.
    pub fn plus_row(&mut self, x: &Value, bias: &Value) -> Value {
        let [n_rows, n_cols] = x.matrix.shape();
        assert_eq!(bias.matrix.shape(), [1, n_cols], "one bias per column");
        let rows = x.matrix.data().chunks_exact(n_cols.max(1));
        let sums = rows.flat_map(|row| row.iter().zip(bias.matrix.data()).map(|(x, bias)| x + bias));
        let result = Matrix::new(n_rows, n_cols, sums.collect());
        self.record(result, [x, bias], |gradient, [to_x, to_bias]| {
            [to_x.then(|| gradient.clone()), to_bias.then(|| linalg::column_sums(gradient))]
        })
    }

    /// Adds two matrices of equal shape.
    pub fn plus(&mut self, a: &Value, b: &Value) -> Value {
        assert_eq!(a.matrix.shape(), b.matrix.shape(), "matrices of one shape");
        let result = entrywise(&a.matrix, &b.matrix, |a, b| a + b);
        self.record(result, [a, b], |gradient, needed| needed.map(|is_needed| is_needed.then(|| gradient.clone())))
    }

    /// Stacks two matrices, the rows of `a` above those of `b`.
    pub fn stack_rows(&mut self, a: &Value, b: &Value) -> Value {
        let [n_a, n_b] = [a, b].map(|value| value.matrix.n_rows());
        let result = stack_rows([&a.matrix, &b.matrix]);
        self.record(result, [a, b], move |gradient, [to_a, to_b]| {
            [to_a.then(|| rows(gradient, 0..n_a)), to_b.then(|| rows(gradient, n_a..n_a + n_b))]
        })
    }

    /// Computes `max(x, 0)` per entry.
    pub fn relu(&mut self, x: &Value) -> Value {
        let [n_rows, n_cols] = x.matrix.shape();
        let result = x.matrix.data().iter().map(|x| x.max(0.0)).collect();
        let result = Arc::new(Matrix::new(n_rows, n_cols, result));
        let kept = result.clone();
        self.record(result, [x], move |gradient, _| {
            [Some(entrywise(gradient, &kept, |g, y| if y > 0.0 { g } else { 0.0 }))]
        })
    }

    /// Computes `1 / (1 + exp(-x))` per entry.
    pub fn sigmoid(&mut self, x: &Value) -> Value {
        let [n_rows, n_cols] = x.matrix.shape();
        let result = x.matrix.data().iter().map(|x| 1.0 / (1.0 + (-x).exp())).collect();
        let result = Arc::new(Matrix::new(n_rows, n_cols, result));
        let kept = result.clone();
        self.record(result, [x], move |gradient, _| [Some(entrywise(gradient, &kept, |g, y| g * y * (1.0 - y)))])
    }

    /// Computes the softmax over all entries.
    pub fn softmax(&mut self, x: &Value) -> Value {
        let [n_rows, n_cols] = x.matrix.shape();
        let result = Arc::new(Matrix::new(n_rows, n_cols, softmax(x.matrix.data())));
        let kept = result.clone();
        self.record(result, [x], move |gradient, _| {
            let products = gradient.data().iter().zip(kept.data());
            let mean = products.map(|(g, y)| f64::from(*g) * f64::from(*y)).sum::<f64>() as f32;
            [Some(entrywise(gradient, &kept, |g, y| y * (g - mean)))]
        })
    }

    /// Picks rows by index, with repeats.
    pub fn gather(&mut self, x: &Value, indices: &[u32]) -> Value {
        let result = linalg::gather(&x.matrix, indices);
        let (n_rows, indices) = (x.matrix.n_rows(), indices.to_vec());
        self.record(result, [x], move |gradient, _| [Some(linalg::gather_backward(n_rows, &indices, gradient))])
    }

    /// Computes [`linalg::triple_extremes`] of triples of rows: n x n_cols to n_triples x (3 n_cols).
    pub fn triple_extremes(&mut self, x: &Value, triples: &[[u32; 3]]) -> Value {
        let result = linalg::triple_extremes(&x.matrix, triples);
        let (kept, triples) = (x.matrix.clone(), triples.to_vec());
        self.record(result, [x], move |gradient, _| [Some(linalg::triple_extremes_backward(&kept, &triples, gradient))])
    }

    /// Computes the mean of three entries of a column per triple: n x 1 to n_triples x 1.
    pub fn mean_of_three(&mut self, x: &Value, triples: &Arc<[[u32; 3]]>) -> Value {
        let [n_rows, _] = x.matrix.shape();
        let mean = |triple: &[u32; 3]| triple.iter().map(|&at| x.matrix.data()[at as usize]).sum::<f32>() / 3.0;
        let result = Matrix::new(triples.len(), 1, triples.iter().map(mean).collect());
        let triples = triples.clone();
        self.record(result, [x], move |gradient, _| {
            let mut to_x = vec![0.0; n_rows];
            for (triple, gradient) in triples.iter().zip(gradient.data()) {
                triple.iter().for_each(|&at| to_x[at as usize] += gradient / 3.0);
            }
            [Some(Matrix::new(n_rows, 1, to_x))]
        })
    }
}

fn softmax(x: &[f32]) -> Vec<f32> {
    // Subtracting the largest entry keeps the exponentials finite.
    let largest = x.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let mut result: Vec<f32> = x.iter().map(|x| (x - largest).exp()).collect();
    let sum: f64 = result.iter().map(|&y| f64::from(y)).sum();
    result.iter_mut().for_each(|y| *y = (f64::from(*y) / sum) as f32);
    result
}

pub(super) fn stacked_weights_backward(parts: [&Matrix; 2], gradient: &Matrix) -> Matrix {
    let [of_a, of_b] = parts.map(|part| product_weights_backward(part, gradient));
    stack_rows([&of_a, &of_b])
}

fn stack_rows([a, b]: [&Matrix; 2]) -> Matrix {
    assert_eq!(a.n_cols(), b.n_cols(), "rows of one length");
    Matrix::new(a.n_rows() + b.n_rows(), a.n_cols(), [a.data(), b.data()].concat())
}

pub(super) fn rows(m: &Matrix, range: Range<usize>) -> Matrix {
    Matrix::new(range.len(), m.n_cols(), m.data()[range.start * m.n_cols()..range.end * m.n_cols()].to_vec())
}

pub(super) fn entrywise(a: &Matrix, b: &Matrix, f: impl Fn(f32, f32) -> f32) -> Matrix {
    let entries = a.data().iter().zip(b.data()).map(|(a, b)| f(*a, *b));
    Matrix::new(a.n_rows(), a.n_cols(), entries.collect())
}

#[cfg(test)]
mod tests {
    use super::super::test_gradients::check_gradients;
    use super::*;
    use crate::linalg::test_values::random;

    #[test]
    fn gradients_of_products() {
        let inputs = [random(30, 5, 1), random(5, 7, 2), random(1, 7, 3)];
        check_gradients(&inputs, |tape, v| tape.product(&v[0], &v[1]));
        check_gradients(&inputs, |tape, v| tape.affine(&v[0], &v[1], &v[2]));
        check_gradients(&[random(30, 5, 1), random(1, 5, 2)], |tape, v| tape.plus_row(&v[0], &v[1]));
        let layers = [random(30, 5, 1), random(5, 7, 2), random(1, 7, 3), random(7, 2, 4), random(1, 2, 5)];
        check_gradients(&layers, |tape, v| tape.two_layers(&v[0], [&v[1], &v[2]], [&v[3], &v[4]]));
        let inputs = [random(30, 5, 1), random(30, 4, 2), random(9, 7, 3)];
        check_gradients(&inputs, |tape, v| tape.concat_product(&v[0], &v[1], &v[2]));
    }

    #[test]
    fn gradients_of_entrywise_operations() {
        let inputs = [random(12, 3, 1)];
        check_gradients(&inputs, |tape, v| tape.relu(&v[0]));
        check_gradients(&inputs, |tape, v| tape.sigmoid(&v[0]));
        check_gradients(&inputs, |tape, v| tape.softmax(&v[0]));
        let triples: Arc<[[u32; 3]]> = [[0, 1, 2], [2, 7, 11], [2, 0, 3]].into();
        check_gradients(&[random(12, 1, 3)], |tape, v| tape.mean_of_three(&v[0], &triples));
    }

    #[test]
    fn gradients_of_rows_by_index() {
        let inputs = [random(12, 3, 1)];
        check_gradients(&inputs, |tape, v| tape.gather(&v[0], &[3, 3, 0, 11, 3]));
        check_gradients(&[random(4, 3, 1), random(2, 3, 2)], |tape, v| tape.stack_rows(&v[0], &v[1]));
        check_gradients(&[random(4, 3, 1), random(4, 3, 2)], |tape, v| tape.plus(&v[0], &v[1]));
        check_gradients(&inputs, |tape, v| tape.triple_extremes(&v[0], &[[0, 1, 2], [2, 7, 11], [2, 0, 3]]));
    }

    #[test]
    fn softmax_sums_to_one_and_stays_finite() {
        let mut tape = Tape::default();
        let y = tape.softmax(&Value::constant(Matrix::new(3, 1, vec![1e30, 1e30, -1e30])));
        assert_eq!(y.matrix().data(), [0.5, 0.5, 0.0]);
    }
}
