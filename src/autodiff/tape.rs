//! The tape: which operations led from parameters to results, and the walk back.

use crate::linalg::Matrix;
use std::sync::Arc;

/// A matrix in a computation: a constant, or something that depends on parameters of a [`Tape`].
///
/// Cloning shares the matrix.
#[derive(Clone, Debug)]
pub struct Value {
    pub(super) matrix: Arc<Matrix>,
    node: Option<usize>,
}

impl Value {
    /// A matrix that no gradient is asked for.
    pub fn constant(matrix: impl Into<Arc<Matrix>>) -> Self {
        Self { matrix: matrix.into(), node: None }
    }

    /// The matrix itself.
    pub fn matrix(&self) -> &Matrix {
        &self.matrix
    }

    /// Whether nothing upstream is a parameter.
    pub fn is_constant(&self) -> bool {
        self.node.is_none()
    }
}

/// Gradients of an operation's inputs from that of its result; none for constants.
type Backward = Box<dyn Fn(&Matrix) -> Vec<Option<Matrix>> + Send>;

struct Node {
    inputs: Vec<Option<usize>>,
    /// `None` for parameters.
    backward: Option<Backward>,
}

/// The operations that were applied to parameters, in order.
///
/// Values of one tape must not be used on another.
///
/// ```
/// use neural_mesh::{autodiff::{Tape, Value}, linalg::Matrix};
/// let mut tape = Tape::default();
/// let x = Value::constant(Matrix::new(1, 2, vec![3.0, 5.0]));
/// let w = tape.parameter(Matrix::new(2, 1, vec![1.0, 1.0]));
/// let y = tape.product(&x, &w);
/// let gradients = tape.backward(&[(&y, Matrix::new(1, 1, vec![1.0]))]);
/// assert_eq!(gradients.of(&w).unwrap().data(), [3.0, 5.0]);
/// assert!(gradients.of(&x).is_none());
/// ```
#[derive(Default)]
pub struct Tape {
    nodes: Vec<Node>,
}

impl Tape {
    /// A matrix whose gradient will be asked for.
    pub fn parameter(&mut self, matrix: impl Into<Arc<Matrix>>) -> Value {
        self.nodes.push(Node { inputs: Vec::new(), backward: None });
        Value { matrix: matrix.into(), node: Some(self.nodes.len() - 1) }
    }

    /// Number of parameters and recorded operations.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Whether nothing was recorded.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Notes down that `result` came from `inputs`, where one of them depends on a parameter. `backward` turns the
    /// gradient of the result into those of the inputs; its flags say which of them are asked for.
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
        self.nodes.push(Node { inputs: inputs.map(|input| input.node).into(), backward: Some(backward) });
        Value { matrix: result.into(), node: Some(self.nodes.len() - 1) }
    }

    /// Carries gradients of results back to the parameters; what reaches one value on several ways is summed.
    ///
    /// `results` holds values of this tape with the gradients of the loss to them, of the same shapes. Constants
    /// among them are passed over.
    ///
    /// # Panics
    /// When a gradient has another shape than its value.
    pub fn backward(&self, results: &[(&Value, Matrix)]) -> Gradients {
        let mut gradients: Vec<Option<Matrix>> = self.nodes.iter().map(|_| None).collect();
        for (value, gradient) in results {
            assert_eq!(value.matrix.shape(), gradient.shape(), "a gradient of its value's shape");
            if let Some(node) = value.node {
                accumulate(&mut gradients[node], gradient.clone());
            }
        }
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
    /// The gradient of a parameter; `None` where the results do not depend on it, and for anything else.
    pub fn of(&self, parameter: &Value) -> Option<&Matrix> {
        self.gradients.get(parameter.node?)?.as_ref()
    }

    /// The same, zero where the results do not depend on it.
    ///
    /// ```
    /// use neural_mesh::{autodiff::Tape, linalg::Matrix};
    /// let mut tape = Tape::default();
    /// let unused = tape.parameter(Matrix::zeros(2, 1));
    /// assert_eq!(tape.backward(&[]).or_zero(&unused), Matrix::zeros(2, 1));
    /// ```
    pub fn or_zero(&self, parameter: &Value) -> Matrix {
        let [n_rows, n_cols] = parameter.matrix().shape();
        self.of(parameter).cloned().unwrap_or_else(|| Matrix::zeros(n_rows, n_cols))
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
        assert_eq!(gradients.of(&x).unwrap().data(), [6.0]);
    }
}
