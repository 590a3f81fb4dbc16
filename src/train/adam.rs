//! Adam (Kingma and Ba 2015), Algorithm 1, with bias correction, and the clipping of gradients.

use super::Settings;
use crate::linalg::Matrix;
use crate::model::Network;
use std::sync::Arc;

/// Running means of the gradients and of their squares.
#[derive(Clone, Debug, PartialEq)]
pub struct Moments {
    /// m, one matrix per tensor.
    pub first: Network<Matrix>,
    /// v, one matrix per tensor.
    pub second: Network<Matrix>,
    /// t, the number of steps done.
    pub steps: u64,
}

impl Moments {
    /// Before the first step, for a network of these shapes.
    pub fn zero(shapes: &Network<[usize; 2]>) -> Self {
        let zeros = || shapes.map(|_, &[n_rows, n_cols]| Matrix::zeros(n_rows, n_cols));
        Self { first: zeros(), second: zeros(), steps: 0 }
    }
}

/// One step: the new tensors; the moments move on.
///
/// `m = b1 m + (1 - b1) g`, `v = b2 v + (1 - b2) g^2`, `w -= rate * (m / (1 - b1^t)) / (sqrt(v / (1 - b2^t)) + e)`.
///
/// # Shapes
/// - `tensors`, `gradients` and `moments`: the same
///
/// # Panics
/// When they are networks of other sizes.
///
/// ```
/// use neural_mesh::{linalg::Matrix, model::Weights, train::{Moments, Settings, adam_step}};
/// let weights = Weights::random(1);
/// let gradients = weights.tensors().map(|_, w| Matrix::from_fn(w.n_rows(), w.n_cols(), |_, _| 7.0));
/// let mut moments = Moments::zero(&weights.architecture().shapes());
/// let settings = Settings::from_toml("").unwrap();
/// let after = adam_step(weights.tensors(), &gradients, &mut moments, &settings, 0.5);
/// // Whatever the size of the gradient, the first step is as long as the learning rate.
/// let [before, after] = [weights.tensors(), &after].map(|net| net.point_sampler.score.bias.data()[0]);
/// assert!((before - after - 0.5).abs() < 1e-6);
/// ```
pub fn adam_step(
    tensors: &Network<Arc<Matrix>>,
    gradients: &Network<Matrix>,
    moments: &mut Moments,
    settings: &Settings,
    learning_rate: f64,
) -> Network<Arc<Matrix>> {
    moments.steps += 1;
    let (beta1, beta2) = (settings.adam_beta1, settings.adam_beta2);
    moments.first = blended(&moments.first, gradients, |m, g| beta1 * m + (1.0 - beta1) * g);
    moments.second = blended(&moments.second, gradients, |v, g| beta2 * v + (1.0 - beta2) * g * g);
    let [first, second] = [beta1, beta2].map(|beta| 1.0 - beta.powf(moments.steps as f64));
    let direction =
        blended(&moments.first, &moments.second, |m, v| (m / first) / ((v / second).sqrt() + settings.adam_epsilon));
    let mut directions = matrices(&direction).into_iter();
    tensors.map(|_, matrix| {
        let direction = directions.next().unwrap_or_default();
        let moved = |(&w, &d): (&f32, &f32)| (f64::from(w) - learning_rate * f64::from(d)) as f32;
        let data = matrix.data().iter().zip(direction.data()).map(moved).collect();
        Arc::new(Matrix::new(matrix.n_rows(), matrix.n_cols(), data))
    })
}

/// The length of the gradients over all tensors together.
pub(super) fn gradient_norm(gradients: &Network<Matrix>) -> f64 {
    let mut square = 0.0;
    gradients.map(|_, matrix| square += matrix.data().iter().map(|&g| f64::from(g).powi(2)).sum::<f64>());
    square.sqrt()
}

/// The gradients, shortened to the length `limit` where `norm` is larger; 0 is no limit.
pub(super) fn clipped(gradients: Network<Matrix>, norm: f64, limit: f64) -> Network<Matrix> {
    if limit == 0.0 || norm <= limit {
        return gradients;
    }
    let shrink = |g: &f32| (f64::from(*g) * (limit / norm)) as f32;
    gradients.map(|_, matrix| Matrix::new(matrix.n_rows(), matrix.n_cols(), matrix.data().iter().map(shrink).collect()))
}

/// `f(a, b)` entry by entry.
fn blended(a: &Network<Matrix>, b: &Network<Matrix>, f: impl Fn(f64, f64) -> f64) -> Network<Matrix> {
    let mut others = matrices(b).into_iter();
    a.map(|_, matrix| {
        let other = others.next().unwrap_or_default();
        assert_eq!(matrix.shape(), other.shape(), "networks of the same sizes");
        let entries = matrix.data().iter().zip(other.data()).map(|(&a, &b)| f(f64::from(a), f64::from(b)) as f32);
        Matrix::new(matrix.n_rows(), matrix.n_cols(), entries.collect())
    })
}

/// Copies of all tensors in the order of the walk.
fn matrices(network: &Network<Matrix>) -> Vec<Matrix> {
    let mut all = Vec::new();
    network.map(|_, matrix| all.push(matrix.clone()));
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Architecture, Weights};

    fn settings() -> Settings {
        Settings::from_toml("").unwrap()
    }

    /// A network all of whose entries are `value`.
    fn filled(value: f32) -> Network<Matrix> {
        let shapes = Architecture { point_sampler_layers: 1, face_classifier_layers: 1, ..Default::default() }.shapes();
        shapes.map(|_, &[n_rows, n_cols]| Matrix::from_fn(n_rows, n_cols, |_, _| value))
    }

    fn entry(network: &Network<Arc<Matrix>>) -> f64 {
        f64::from(network.point_sampler.score.bias.data()[0])
    }

    #[test]
    fn three_steps_follow_the_naive_formula() {
        let mut moments = Moments::zero(&filled(0.0).map(|_, matrix| matrix.shape()));
        let mut tensors = filled(1.0).map(|_, matrix| Arc::new(matrix.clone()));
        let (mut w, mut m, mut v) = (1.0f64, 0.0f64, 0.0f64);
        for (t, g) in [(1, 0.5f64), (2, -0.25), (3, 4.0)] {
            tensors = adam_step(&tensors, &filled(g as f32), &mut moments, &settings(), 0.1);
            m = 0.9 * m + 0.1 * g;
            v = 0.999 * v + 0.001 * g * g;
            let (m_hat, v_hat) = (m / (1.0 - 0.9f64.powi(t)), v / (1.0 - 0.999f64.powi(t)));
            w -= 0.1 * m_hat / (v_hat.sqrt() + 1e-8);
            assert!((entry(&tensors) - w).abs() < 1e-6, "{t}: {} {w}", entry(&tensors));
        }
    }

    #[test]
    fn the_least_of_a_square_is_found() {
        let mut tensors = filled(3.0).map(|_, matrix| Arc::new(matrix.clone()));
        let mut moments = Moments::zero(&filled(0.0).map(|_, matrix| matrix.shape()));
        for _ in 0..150 {
            let gradient = 2.0 * (entry(&tensors) - 2.5) as f32;
            tensors = adam_step(&tensors, &filled(gradient), &mut moments, &settings(), 0.05);
        }
        assert!((entry(&tensors) - 2.5).abs() < 0.02, "{}", entry(&tensors));
    }

    #[test]
    fn long_gradients_are_shortened_and_keep_their_direction() {
        let gradients = Weights::random(3).tensors().map(|_, matrix| matrix.as_ref().clone());
        let norm = gradient_norm(&gradients);
        assert_eq!(clipped(gradients.clone(), norm, 0.0), gradients);
        assert_eq!(clipped(gradients.clone(), norm, 2.0 * norm), gradients);
        let short = clipped(gradients.clone(), norm, 0.5);
        assert!((gradient_norm(&short) - 0.5).abs() < 1e-6);
        let [long, short] = [&gradients, &short].map(|net| net.point_sampler.score.weights.data()[5]);
        assert!((f64::from(long) * 0.5 / norm - f64::from(short)).abs() < 1e-6);
    }
}
