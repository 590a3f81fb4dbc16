//! Operations on whole matrices.

use super::{Tape, Value};
use crate::linalg::{
    Matrix, product, product_input_backward, product_relu, product_repeated_bias, product_weights_backward,
};
use std::sync::Arc;

impl Tape {
    /// `x w`: n x n_in times n_in x n_out.
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

    /// `max(x w, 0)`, one pass.
    pub fn product_relu(&mut self, x: &Value, weights: &Value) -> Value {
        let result = Arc::new(product_relu(&x.matrix, &weights.matrix, &[]));
        let (x_kept, weights_kept, active) = (x.matrix.clone(), weights.matrix.clone(), result.clone());
        self.record(result, [x, weights], move |gradient, [to_x, to_weights]| {
            let gradient = entrywise(gradient, &active, |g, y| if y > 0.0 { g } else { 0.0 });
            [
                to_x.then(|| product_input_backward(&gradient, &weights_kept)),
                to_weights.then(|| product_weights_backward(&x_kept, &gradient)),
            ]
        })
    }

    /// `x w + bias`, the bias 1 x n_out.
    pub fn affine(&mut self, x: &Value, weights: &Value, bias: &Value) -> Value {
        self.affine_repeated(x, weights, bias, &vec![1.0; x.matrix.n_rows()].into())
    }

    /// `x w + repeats bias`: row `i` of the result gets `repeats[i]` times the bias, 1 x n_out.
    pub fn affine_repeated(&mut self, x: &Value, weights: &Value, bias: &Value, repeats: &Arc<[f32]>) -> Value {
        let result = product_repeated_bias(&x.matrix, &weights.matrix, bias.matrix.data(), repeats);
        let (x_kept, weights_kept, repeats) = (x.matrix.clone(), weights.matrix.clone(), repeats.clone());
        self.record(result, [x, weights, bias], move |gradient, [to_x, to_weights, to_bias]| {
            let repeats = || Matrix::new(repeats.len(), 1, repeats.to_vec());
            [
                to_x.then(|| product_input_backward(gradient, &weights_kept)),
                to_weights.then(|| product_weights_backward(&x_kept, gradient)),
                to_bias.then(|| product_weights_backward(&repeats(), gradient)),
            ]
        })
    }

    /// The columns of `a`, then those of `b`: n x (a + b).
    ///
    /// # Panics
    /// When the numbers of rows differ.
    pub fn concat(&mut self, a: &Value, b: &Value) -> Value {
        let [n_rows, a_cols] = a.matrix.shape();
        let b_cols = b.matrix.n_cols();
        assert_eq!(n_rows, b.matrix.n_rows(), "as many rows on both sides");
        let mut data = Vec::with_capacity(n_rows * (a_cols + b_cols));
        for row in 0..n_rows {
            data.extend_from_slice(a.matrix.row(row));
            data.extend_from_slice(b.matrix.row(row));
        }
        self.record(Matrix::new(n_rows, a_cols + b_cols, data), [a, b], move |gradient, [to_a, to_b]| {
            let part = |from: usize, n_cols| Matrix::from_fn(n_rows, n_cols, |row, col| gradient.row(row)[from + col]);
            [to_a.then(|| part(0, a_cols)), to_b.then(|| part(a_cols, b_cols))]
        })
    }

    /// `1 / (1 + exp(-x))`, entry by entry.
    pub fn sigmoid(&mut self, x: &Value) -> Value {
        let [n_rows, n_cols] = x.matrix.shape();
        let result = x.matrix.data().iter().map(|x| 1.0 / (1.0 + (-x).exp())).collect();
        let result = Arc::new(Matrix::new(n_rows, n_cols, result));
        let kept = result.clone();
        self.record(result, [x], move |gradient, _| [Some(entrywise(gradient, &kept, |g, y| g * y * (1.0 - y)))])
    }

    /// The softmax over all entries: positive, summing to 1.
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

    /// The mean of three entries of a column, for each triple of row indices: n x 1 to n_triples x 1.
    ///
    /// # Panics
    /// When an index is out of range.
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
    let largest = x.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let mut result: Vec<f32> = x.iter().map(|x| (x - largest).exp()).collect();
    let sum: f64 = result.iter().map(|&y| f64::from(y)).sum();
    result.iter_mut().for_each(|y| *y = (f64::from(*y) / sum) as f32);
    result
}

fn entrywise(a: &Matrix, b: &Matrix, f: impl Fn(f32, f32) -> f32) -> Matrix {
    let entries = a.data().iter().zip(b.data()).map(|(a, b)| f(*a, *b));
    Matrix::new(a.n_rows(), a.n_cols(), entries.collect())
}

#[cfg(test)]
mod tests {
    use super::super::tape::tests::check_gradients;
    use super::*;
    use crate::linalg::test_values::random;

    #[test]
    fn gradients_of_products() {
        let inputs = [random(30, 5, 1), random(5, 7, 2), random(1, 7, 3)];
        check_gradients(&inputs, |tape, v| tape.product(&v[0], &v[1]));
        check_gradients(&inputs, |tape, v| tape.product_relu(&v[0], &v[1]));
        let repeats: Arc<[f32]> = (0..30).map(|i| (i % 4) as f32).collect();
        check_gradients(&inputs, |tape, v| tape.affine_repeated(&v[0], &v[1], &v[2], &repeats));
    }

    #[test]
    fn gradients_of_entrywise_operations() {
        let inputs = [random(12, 3, 1), random(12, 4, 2)];
        check_gradients(&inputs, |tape, v| tape.concat(&v[0], &v[1]));
        check_gradients(&inputs[..1], |tape, v| tape.sigmoid(&v[0]));
        check_gradients(&inputs[..1], |tape, v| tape.softmax(&v[0]));
        let triples: Arc<[[u32; 3]]> = [[0, 1, 2], [2, 7, 11], [2, 0, 3]].into();
        check_gradients(&[random(12, 1, 3)], |tape, v| tape.mean_of_three(&v[0], &triples));
    }

    #[test]
    fn softmax_sums_to_one_and_stays_finite() {
        let mut tape = Tape::default();
        let y = tape.softmax(&Value::constant(Matrix::new(3, 1, vec![1e30, 1e30, -1e30])));
        assert_eq!(y.matrix().data(), [0.5, 0.5, 0.0]);
    }
}
