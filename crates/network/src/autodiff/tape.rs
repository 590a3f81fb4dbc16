//! The tape: records operations on parameters and differentiates them backwards.

use crate::linalg::Matrix;
use std::sync::Arc;

/// A matrix in a computation, constant or dependent on parameters of a [`Tape`]; clones share the matrix.
#[derive(Clone, Debug)]
pub struct Value {
    pub(super) matrix: Arc<Matrix>,
    node: Option<usize>,
}

impl Value {
    /// Wraps a matrix without gradient.
    pub fn constant(matrix: impl Into<Arc<Matrix>>) -> Self {
        Self { matrix: matrix.into(), node: None }
    }

    /// Returns the matrix.
    pub fn matrix(&self) -> &Matrix {
        &self.matrix
    }

    /// Returns whether the value depends on no parameter.
    pub fn is_constant(&self) -> bool {
        self.node.is_none()
    }
}

/// Function from the gradient of an operation's result to those of its inputs, `None` for constants.
type Backward = Box<dyn Fn(&Matrix) -> Vec<Option<Matrix>> + Send>;

struct TapeNode {
    inputs: Vec<Option<usize>>,
    /// Backward function; `None` for parameters.
    backward: Option<Backward>,
}

/// The operations applied to parameters, in order.
///
/// Values of one tape must not be used on another.
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::{autodiff::{Tape, Value}, linalg::Matrix};
/// let mut tape = Tape::default();
/// let x = Value::constant(Matrix::new(1, 2, vec![3.0, 5.0]));
/// let w = tape.parameter(Matrix::new(2, 1, vec![1.0, 1.0]));
/// let y = tape.product(&x, &w);
/// let gradients = tape.backward(&[(&y, Matrix::new(1, 1, vec![1.0]))]);
/// assert_eq!(gradients.get(&w).unwrap().data(), [3.0, 5.0]);
/// assert!(gradients.get(&x).is_none());
/// ```
#[derive(Default)]
pub struct Tape {
    nodes: Vec<TapeNode>,
}

impl Tape {
    /// Adds a parameter, a matrix that gets a gradient.
    pub fn parameter(&mut self, matrix: impl Into<Arc<Matrix>>) -> Value {
        self.nodes.push(TapeNode { inputs: Vec::new(), backward: None });
        Value { matrix: matrix.into(), node: Some(self.nodes.len() - 1) }
    }

    /// Returns the number of parameters and recorded operations.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Returns whether nothing was recorded.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Records `result` as computed from `inputs`, unless all inputs are constant.
    ///
    /// `backward` turns the gradient of the result into those of the inputs; its flags mark the inputs that need one.
    pub(super) fn record<const N: usize>(
        &mut self,
        result: impl Into<Arc<Matrix>>,
        inputs: [&Value; N],
        backward: impl Fn(&Matrix, [bool; N]) -> [Option<Matrix>; N] + Send + 'static,
    ) -> Value {
        if inputs.iter().all(|input| input.is_constant()) {
            return Value::constant(result);
        }
        let needed = inputs.map(|input| !input.is_constant());
        let backward: Backward = Box::new(move |gradient| backward(gradient, needed).into());
        self.nodes.push(TapeNode { inputs: inputs.map(|input| input.node).into(), backward: Some(backward) });
        Value { matrix: result.into(), node: Some(self.nodes.len() - 1) }
    }

    /// Propagates the given gradients of `results` back to the parameters, summing over all paths.
    pub fn backward(&self, results: &[(&Value, Matrix)]) -> Gradients {
        let mut gradients: Vec<Option<Matrix>> = self.nodes.iter().map(|_| None).collect();
        for (value, gradient) in results {
            assert_eq!(value.matrix.shape(), gradient.shape(), "a gradient of its value's shape");
            if let Some(node) = value.node {
                accumulate(&mut gradients[node], gradient.clone());
            }
        }
        // Operations are visited from last to first, so the gradient of each result is complete before it is passed on.
        for (at, node) in self.nodes.iter().enumerate().rev() {
            let Some(backward) = &node.backward else { continue };
            let Some(gradient) = gradients[at].take() else { continue };
            for (input, gradient) in node.inputs.iter().zip(backward(&gradient)) {
                if let (Some(input), Some(gradient)) = (input, gradient) {
                    accumulate(&mut gradients[*input], gradient);
                }
            }
        }
        Gradients { gradients }
    }
}

fn accumulate(sum: &mut Option<Matrix>, gradient: Matrix) {
    match sum {
        Some(sum) => sum.data_mut().iter_mut().zip(gradient.data()).for_each(|(sum, g)| *sum += g),
        None => *sum = Some(gradient),
    }
}

/// The gradients of a tape's parameters.
#[derive(Clone, Debug)]
pub struct Gradients {
    gradients: Vec<Option<Matrix>>,
}

impl Gradients {
    /// Returns the gradient of a parameter; `None` if the results do not depend on it.
    pub fn get(&self, parameter: &Value) -> Option<&Matrix> {
        self.gradients.get(parameter.node?)?.as_ref()
    }

    /// Returns the gradient of a parameter, zero if the results do not depend on it.
    ///
    /// ```
    /// # use neural_mesh_network as neural_mesh;
    /// use neural_mesh::{autodiff::Tape, linalg::Matrix};
    /// let mut tape = Tape::default();
    /// let unused = tape.parameter(Matrix::zeros(2, 1));
    /// assert_eq!(tape.backward(&[]).or_zero(&unused), Matrix::zeros(2, 1));
    /// ```
    pub fn or_zero(&self, parameter: &Value) -> Matrix {
        let [n_rows, n_cols] = parameter.matrix().shape();
        self.get(parameter).cloned().unwrap_or_else(|| Matrix::zeros(n_rows, n_cols))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::test_values::random;

    #[test]
    fn without_parameters_nothing_is_recorded() {
        let mut tape = Tape::default();
        let [x, w] = [Value::constant(random(3, 4, 1)), Value::constant(random(4, 2, 2))];
        let y = tape.product(&x, &w);
        let y = tape.sigmoid(&y);
        assert!(tape.is_empty() && y.is_constant());
    }

    #[test]
    fn a_value_used_twice_gets_both_gradients() {
        let mut tape = Tape::default();
        let x = tape.parameter(Matrix::new(1, 1, vec![3.0]));
        let y = tape.product(&x, &x);
        assert_eq!(tape.len(), 2);
        let gradients = tape.backward(&[(&y, Matrix::new(1, 1, vec![1.0]))]);
        assert_eq!(gradients.get(&x).unwrap().data(), [6.0]);
    }
}
