//! Named tensors in a fixed order: the parameters of any network.

use super::{Gradients, Tape, Value, WeightsError};
use crate::linalg::Matrix;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};
use std::convert::Infallible;
use std::sync::Arc;

/// The tensors of a network by unique name, in insertion order.
///
/// `T` is a shape, a matrix, a gradient, or a value on a tape.
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::autodiff::Tensors;
/// let shapes: Tensors<[usize; 2]> = [("layer.weights", [3, 8]), ("layer.bias", [1, 8])].into_iter().collect();
/// let tensors = shapes.draw(7);
/// assert_eq!(tensors.get("layer.weights").unwrap().shape(), [3, 8]);
/// assert_eq!(shapes.n_parameters(), 32);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Tensors<T> {
    entries: Vec<(String, T)>,
}

impl<T> Default for Tensors<T> {
    fn default() -> Self {
        Self { entries: Vec::new() }
    }
}

impl<N: Into<String>, T> FromIterator<(N, T)> for Tensors<T> {
    fn from_iter<I: IntoIterator<Item = (N, T)>>(entries: I) -> Self {
        let mut tensors = Self::default();
        entries.into_iter().for_each(|(name, tensor)| tensors.push(name, tensor));
        tensors
    }
}

impl<T> Tensors<T> {
    /// Appends a tensor.
    pub fn push(&mut self, name: impl Into<String>, tensor: T) {
        let name = name.into();
        assert!(self.get(&name).is_none(), "each name once");
        self.entries.push((name, tensor));
    }

    /// Returns the number of tensors.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Returns whether there are no tensors.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Returns the tensors with their names, in order.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &T)> {
        self.entries.iter().map(|(name, tensor)| (name.as_str(), tensor))
    }

    /// Returns the tensor with a name.
    pub fn get(&self, name: &str) -> Option<&T> {
        self.iter().find_map(|(other, tensor)| (other == name).then_some(tensor))
    }

    /// Returns the tensor with a name, for writing.
    pub fn get_mut(&mut self, name: &str) -> Option<&mut T> {
        self.entries.iter_mut().find_map(|(other, tensor)| (other == name).then_some(tensor))
    }

    /// Applies `f(name, tensor)` to every tensor in order, until `f` fails.
    pub fn try_map<U, E>(&self, mut f: impl FnMut(&str, &T) -> Result<U, E>) -> Result<Tensors<U>, E> {
        let mapped = self.entries.iter().map(|(name, tensor)| Ok((name.clone(), f(name, tensor)?)));
        Ok(Tensors { entries: mapped.collect::<Result<_, E>>()? })
    }

    /// Applies `f(name, tensor)` to every tensor in order.
    pub fn map<U>(&self, mut f: impl FnMut(&str, &T) -> U) -> Tensors<U> {
        match self.try_map(|name, tensor| Ok::<U, Infallible>(f(name, tensor))) {
            Ok(tensors) => tensors,
            Err(never) => match never {},
        }
    }

    /// Returns the tensor with a name, or [`WeightsError::Missing`].
    pub fn find_tensor(&self, name: &str) -> Result<&T, WeightsError> {
        self.get(name).ok_or_else(|| WeightsError::Missing(name.into()))
    }
}

impl Tensors<[usize; 2]> {
    /// Returns the number of entries over all tensors.
    pub fn n_parameters(&self) -> usize {
        self.iter().map(|(_, [n_rows, n_cols])| n_rows * n_cols).sum()
    }

    /// Draws uniform matrices of these shapes, n_in x n_out, with variance `2 / n_in` (He et al. 2015).
    ///
    /// Tensors whose name ends with `.bias` are zero.
    pub fn draw(&self, seed: u64) -> Tensors<Arc<Matrix>> {
        self.draw_scaled(seed, |_| 1.0)
    }

    /// Draws like [`Tensors::draw`], multiplying each tensor by `share(name)`.
    pub fn draw_scaled(&self, seed: u64, share: impl Fn(&str) -> f32) -> Tensors<Arc<Matrix>> {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut uniform = || (random.next_u64() >> 40) as f32 / (1u64 << 23) as f32 - 1.0;
        self.map(|name, &[n_in, n_out]| {
            if name.ends_with(".bias") {
                return Arc::new(Matrix::zeros(n_in, n_out));
            }
            let limit = share(name) * (6.0 / n_in as f32).sqrt();
            Arc::new(Matrix::from_fn(n_in, n_out, |_, _| limit * uniform()))
        })
    }
}

impl Tensors<Arc<Matrix>> {
    /// Returns the tensors as constants, for inference; matrices are shared.
    pub fn constants(&self) -> Tensors<Value> {
        self.map(|_, matrix| Value::constant(matrix.clone()))
    }

    /// Returns the tensors as parameters of a tape, for training.
    pub fn parameters(&self, tape: &mut Tape) -> Tensors<Value> {
        self.map(|_, matrix| tape.parameter(matrix.clone()))
    }

    /// Returns the tensors that `shapes` names, in its order, after checking them.
    ///
    /// # Errors
    /// [`WeightsError`] names the first that is missing, of another shape or not finite.
    ///
    /// ```
    /// # use neural_mesh_network as neural_mesh;
    /// use neural_mesh::autodiff::{Tensors, WeightsError};
    /// let shapes: Tensors<[usize; 2]> = [("weights", [2, 2])].into_iter().collect();
    /// assert!(shapes.draw(1).check_shapes(&shapes).is_ok());
    /// assert_eq!(Tensors::default().check_shapes(&shapes), Err(WeightsError::Missing("weights".into())));
    /// ```
    pub fn check_shapes(&self, shapes: &Tensors<[usize; 2]>) -> Result<Self, WeightsError> {
        shapes.try_map(|name, &expected| match self.find_tensor(name)? {
            matrix if matrix.shape() != expected => {
                Err(WeightsError::WrongShape { name: name.into(), expected, found: matrix.shape().to_vec() })
            }
            matrix if !matrix.data().iter().all(|x| x.is_finite()) => Err(WeightsError::NotFinite(name.into())),
            matrix => Ok(matrix.clone()),
        })
    }
}

impl Tensors<Value> {
    /// Returns the gradients of these parameters, zero where the results do not depend on one.
    ///
    /// ```
    /// # use neural_mesh_network as neural_mesh;
    /// use neural_mesh::{autodiff::{Tape, Tensors}, linalg::Matrix};
    /// let shapes: Tensors<[usize; 2]> = [("a", [1, 1]), ("b", [1, 1])].into_iter().collect();
    /// let mut tape = Tape::default();
    /// let parameters = shapes.draw(1).parameters(&mut tape);
    /// let a = parameters.get("a").unwrap();
    /// let gradients = parameters.gradients(&tape.backward(&[(a, Matrix::new(1, 1, vec![3.0]))]));
    /// assert_eq!(gradients.get("a").unwrap().data(), [3.0]);
    /// assert_eq!(gradients.get("b").unwrap().data(), [0.0]);
    /// ```
    pub fn gradients(&self, gradients: &Gradients) -> Tensors<Matrix> {
        self.map(|_, value| gradients.or_zero(value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shapes() -> Tensors<[usize; 2]> {
        [("b.weights", [40, 50]), ("a.weights", [100, 20]), ("a.bias", [1, 20])].into_iter().collect()
    }

    #[test]
    fn the_order_is_that_of_adding() {
        let names: Vec<&str> = ["b.weights", "a.weights", "a.bias"].into();
        let (shapes, drawn) = (shapes(), shapes().draw(1));
        assert_eq!(shapes.iter().map(|(name, _)| name).collect::<Vec<_>>(), names);
        assert_eq!(drawn.iter().map(|(name, _)| name).collect::<Vec<_>>(), names);
        // The result follows the order of the shapes.
        let turned: Tensors<Arc<Matrix>> = ["a.bias", "b.weights", "a.weights"]
            .map(|name| (name, drawn.get(name).unwrap().clone()))
            .into_iter()
            .collect();
        assert_eq!(turned.check_shapes(&shapes), Ok(drawn));
    }

    #[test]
    fn draws_have_their_variance_and_biases_none() {
        let drawn = shapes().draw_scaled(3, |name| if name.starts_with('b') { 0.5 } else { 1.0 });
        let variance = |name: &str| {
            let data = drawn.get(name).unwrap().data();
            data.iter().map(|x| f64::from(x * x)).sum::<f64>() / data.len() as f64
        };
        assert!((variance("a.weights") / (2.0 / 100.0) - 1.0).abs() < 0.1, "{}", variance("a.weights"));
        assert!((variance("b.weights") / (0.25 * 2.0 / 40.0) - 1.0).abs() < 0.1, "{}", variance("b.weights"));
        assert_eq!(variance("a.bias"), 0.0);
        assert_ne!(drawn, shapes().draw(4));
    }

    #[test]
    fn tensors_that_are_wrong_are_refused() {
        let (shapes, mut drawn) = (shapes(), shapes().draw(1));
        *drawn.get_mut("a.bias").unwrap() = Arc::new(Matrix::from_fn(1, 20, |_, _| f32::NAN));
        assert_eq!(drawn.check_shapes(&shapes), Err(WeightsError::NotFinite("a.bias".into())));
        *drawn.get_mut("a.bias").unwrap() = Arc::new(Matrix::zeros(20, 1));
        let expected = WeightsError::WrongShape { name: "a.bias".into(), expected: [1, 20], found: vec![20, 1] };
        assert_eq!(drawn.check_shapes(&shapes), Err(expected));
    }

    #[test]
    #[should_panic(expected = "each name once")]
    fn a_repeated_name_is_refused() {
        let _: Tensors<u8> = [("a", 1), ("a", 2)].into_iter().collect();
    }
}
