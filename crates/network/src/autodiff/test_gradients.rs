//! Comparison of gradients with central differences.

use super::{Tape, Value};
use crate::linalg::Matrix;
use crate::linalg::test_values::random;

/// Panics unless the gradients of `f` match central differences along at least three of nine random directions.
pub(crate) fn check_gradients(inputs: &[Matrix], f: impl Fn(&mut Tape, &[Value]) -> Value) {
    let mut tape = Tape::default();
    let parameters: Vec<Value> = inputs.iter().map(|m| tape.parameter(m.clone())).collect();
    let result = f(&mut tape, &parameters);
    let [n_rows, n_cols] = result.matrix().shape();
    let weights = random(n_rows, n_cols, 77);
    let gradients = tape.backward(&[(&result, weights.clone())]);
    let error = |seed: u64| {
        let directions: Vec<Matrix> = inputs.iter().map(|m| random(m.n_rows(), m.n_cols(), seed)).collect();
        let loss = |step: f32| {
            let moved = inputs.iter().zip(&directions).map(|(m, d)| Value::constant(move_along(m, d, step)));
            dot(f(&mut Tape::default(), &moved.collect::<Vec<_>>()).matrix(), &weights)
        };
        let numeric = (loss(5e-4) - loss(-5e-4)) / 1e-3;
        let parts = parameters.iter().zip(&directions);
        let analytic: f64 = parts.map(|(p, d)| gradients.get(p).map_or(0.0, |gradient| dot(gradient, d))).sum();
        (numeric - analytic).abs() / analytic.abs().max(1.0)
    };
    let mut errors: Vec<f64> = (100..109).map(error).collect();
    errors.sort_by(f64::total_cmp);
    assert!(errors[2] < 1e-3, "relative errors {errors:?}");
}

fn move_along(m: &Matrix, direction: &Matrix, step: f32) -> Matrix {
    Matrix::from_fn(m.n_rows(), m.n_cols(), |i, c| m.row(i)[c] + step * direction.row(i)[c])
}

fn dot(a: &Matrix, b: &Matrix) -> f64 {
    a.data().iter().zip(b.data()).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum()
}
