//! Adam (Kingma and Ba 2015), Algorithm 1, and gradient clipping.

use super::Settings;
use crate::autodiff::Tensors;
use crate::linalg::Matrix;
use std::sync::Arc;

/// Running means of the gradients and of their squares.
#[derive(Clone, Debug, PartialEq)]
pub struct Moments {
    /// m, one matrix per tensor.
    pub first: Tensors<Matrix>,
    /// v, one matrix per tensor.
    pub second: Tensors<Matrix>,
    /// t, the number of steps done.
    pub steps: u64,
}

impl Moments {
    /// Returns the moments before the first step.
    pub fn zero(shapes: &Tensors<[usize; 2]>) -> Self {
        let zeros = || shapes.map(|_, &[n_rows, n_cols]| Matrix::zeros(n_rows, n_cols));
        Self { first: zeros(), second: zeros(), steps: 0 }
    }
}

/// Computes the tensors after one step and updates the moments.
///
/// `m = b1 m + (1 - b1) g`, `v = b2 v + (1 - b2) g^2`, `w -= rate * (m / (1 - b1^t)) / (sqrt(v / (1 - b2^t)) + e)`.
///
/// # Panics
/// Unless all arguments have the same sizes.
///
/// ```
/// use neural_mesh::{autodiff::Tensors, linalg::Matrix, train::{Moments, Settings, adam_step}};
/// let shapes: Tensors<[usize; 2]> = [("score.bias", [1, 1]), ("score.weights", [64, 1])].into_iter().collect();
/// let tensors = shapes.draw(1);
/// let gradients = tensors.map(|_, w| Matrix::from_fn(w.n_rows(), w.n_cols(), |_, _| 7.0));
/// let mut moments = Moments::zero(&shapes);
/// let settings = Settings::from_toml("").unwrap();
/// let after = adam_step(&tensors, &gradients, &mut moments, &settings, 0.5);
/// // Whatever the size of the gradient, the first step is as long as the learning rate.
/// let [before, after] = [&tensors, &after].map(|tensors| tensors.get("score.weights").unwrap().data()[0]);
/// assert!((before - after - 0.5).abs() < 1e-6);
/// ```
pub fn adam_step(
    tensors: &Tensors<Arc<Matrix>>,
    gradients: &Tensors<Matrix>,
    moments: &mut Moments,
    settings: &Settings,
    learning_rate: f64,
) -> Tensors<Arc<Matrix>> {
    moments.steps += 1;
    let (beta1, beta2) = (settings.adam_beta1, settings.adam_beta2);
    moments.first = combine_entries(&moments.first, gradients, |m, g| beta1 * m + (1.0 - beta1) * g);
    moments.second = combine_entries(&moments.second, gradients, |v, g| beta2 * v + (1.0 - beta2) * g * g);
    let [first, second] = [beta1, beta2].map(|beta| 1.0 - beta.powf(moments.steps as f64));
    let direction = combine_entries(&moments.first, &moments.second, |m, v| {
        (m / first) / ((v / second).sqrt() + settings.adam_epsilon)
    });
    let mut directions = direction.iter();
    tensors.map(|_, matrix| {
        let (_, direction) = directions.next().expect("one direction per tensor");
        let moved = |(&w, &d): (&f32, &f32)| (f64::from(w) - learning_rate * f64::from(d)) as f32;
        let data = matrix.data().iter().zip(direction.data()).map(moved).collect();
        Arc::new(Matrix::new(matrix.n_rows(), matrix.n_cols(), data))
    })
}

pub(super) fn gradient_norm(gradients: &Tensors<Matrix>) -> f64 {
    let squares = gradients.iter().map(|(_, matrix)| matrix.data().iter().map(|&g| f64::from(g).powi(2)).sum::<f64>());
    squares.sum::<f64>().sqrt()
}

/// Scales the gradients to the norm `limit` if `norm` is larger; 0 means no limit.
pub(super) fn clip_gradients(gradients: Tensors<Matrix>, norm: f64, limit: f64) -> Tensors<Matrix> {
    if limit == 0.0 || norm <= limit {
        return gradients;
    }
    let shrink = |g: &f32| (f64::from(*g) * (limit / norm)) as f32;
    gradients.map(|_, matrix| Matrix::new(matrix.n_rows(), matrix.n_cols(), matrix.data().iter().map(shrink).collect()))
}

fn combine_entries(a: &Tensors<Matrix>, b: &Tensors<Matrix>, f: impl Fn(f64, f64) -> f64) -> Tensors<Matrix> {
    assert_eq!(a.len(), b.len(), "as many tensors");
    let mut others = b.iter();
    a.map(|_, matrix| {
        let (_, other) = others.next().expect("as many tensors");
        assert_eq!(matrix.shape(), other.shape(), "tensors of the same sizes");
        let entries = matrix.data().iter().zip(other.data()).map(|(&a, &b)| f(f64::from(a), f64::from(b)) as f32);
        Matrix::new(matrix.n_rows(), matrix.n_cols(), entries.collect())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings() -> Settings {
        Settings::from_toml("").unwrap()
    }

    fn shapes() -> Tensors<[usize; 2]> {
        [("a.weights", [7, 5]), ("a.bias", [1, 5]), ("b.weights", [5, 1])].into_iter().collect()
    }

    fn fill_tensors(value: f32) -> Tensors<Matrix> {
        shapes().map(|_, &[n_rows, n_cols]| Matrix::from_fn(n_rows, n_cols, |_, _| value))
    }

    fn entry(tensors: &Tensors<Arc<Matrix>>) -> f64 {
        f64::from(tensors.get("a.bias").unwrap().data()[0])
    }

    #[test]
    fn three_steps_follow_the_naive_formula() {
        let mut moments = Moments::zero(&shapes());
        let mut tensors = fill_tensors(1.0).map(|_, matrix| Arc::new(matrix.clone()));
        let (mut w, mut m, mut v) = (1.0f64, 0.0f64, 0.0f64);
        for (t, g) in [(1, 0.5f64), (2, -0.25), (3, 4.0)] {
            tensors = adam_step(&tensors, &fill_tensors(g as f32), &mut moments, &settings(), 0.1);
            m = 0.9 * m + 0.1 * g;
            v = 0.999 * v + 0.001 * g * g;
            let (m_hat, v_hat) = (m / (1.0 - 0.9f64.powi(t)), v / (1.0 - 0.999f64.powi(t)));
            w -= 0.1 * m_hat / (v_hat.sqrt() + 1e-8);
            assert!((entry(&tensors) - w).abs() < 1e-6, "{t}: {} {w}", entry(&tensors));
        }
    }

    #[test]
    fn the_least_of_a_square_is_found() {
        let mut tensors = fill_tensors(3.0).map(|_, matrix| Arc::new(matrix.clone()));
        let mut moments = Moments::zero(&shapes());
        for _ in 0..150 {
            let gradient = 2.0 * (entry(&tensors) - 2.5) as f32;
            tensors = adam_step(&tensors, &fill_tensors(gradient), &mut moments, &settings(), 0.05);
        }
        assert!((entry(&tensors) - 2.5).abs() < 0.02, "{}", entry(&tensors));
    }

    #[test]
    fn long_gradients_are_shortened_and_keep_their_direction() {
        let gradients = shapes().draw(3).map(|_, matrix| matrix.as_ref().clone());
        let norm = gradient_norm(&gradients);
        assert_eq!(clip_gradients(gradients.clone(), norm, 0.0), gradients);
        assert_eq!(clip_gradients(gradients.clone(), norm, 2.0 * norm), gradients);
        let short = clip_gradients(gradients.clone(), norm, 0.5);
        assert!((gradient_norm(&short) - 0.5).abs() < 1e-6);
        let [long, short] = [&gradients, &short].map(|tensors| tensors.get("a.weights").unwrap().data()[5]);
        assert!((f64::from(long) * 0.5 / norm - f64::from(short)).abs() < 1e-6);
    }
}
