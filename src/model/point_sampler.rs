//! The Point Sampler, Sec. 3.1: a score for every vertex, and the multinomial distribution that the scores are.

use super::{Affine, DevConv, dev_conv};
use crate::autodiff::{Tape, Value};
use crate::linalg::Csr;
use std::sync::Arc;

/// Stacked DevConv layers and a linear map to one score.
#[derive(Clone, Debug, PartialEq)]
pub struct PointSampler<T> {
    /// The layers, the first over positions.
    pub dev_convs: Vec<DevConv<T>>,
    /// width to 1.
    pub score: Affine<T>,
}

/// Scores every vertex; larger ones are sampled sooner. Any number; only differences of scores matter.
///
/// # Shapes
/// - `points`: n x 3, normalized
/// - `rings`: n x n, the edges of the mesh
/// - returns n x 1
///
/// ```
/// use neural_mesh::{autodiff::{Tape, Value}, linalg::{Csr, Matrix}, model::{Weights, point_sampler}};
/// let weights = Weights::random(1);
/// let points = Value::constant(Matrix::new(2, 3, vec![0.0, 0.0, 0.0, 0.5, 0.0, 0.0]));
/// let rings = Csr::from_edges(2, [[0, 1]]).into();
/// let scores = point_sampler(&mut Tape::default(), &weights.constants().point_sampler, &points, &rings);
/// assert_eq!(scores.matrix().shape(), [2, 1]);
/// ```
pub fn point_sampler(tape: &mut Tape, net: &PointSampler<Value>, points: &Value, rings: &Arc<Csr>) -> Value {
    let features = net.dev_convs.iter().fold(points.clone(), |x, layer| dev_conv(tape, layer, &x, rings));
    tape.affine(&features, &net.score.weights, &net.score.bias)
}

/// The probabilities of a multinomial distribution over the mesh from its scores: the softmax, which sums to 1.
///
/// # Shapes
/// - `scores`: n x 1
/// - returns n x 1
///
/// ```
/// use neural_mesh::{autodiff::{Tape, Value}, linalg::Matrix, model::inclusion_probabilities};
/// let scores = Value::constant(Matrix::new(2, 1, vec![7.0, 7.0]));
/// assert_eq!(inclusion_probabilities(&mut Tape::default(), &scores).matrix().data(), [0.5, 0.5]);
/// ```
pub fn inclusion_probabilities(tape: &mut Tape, scores: &Value) -> Value {
    tape.softmax(scores)
}

impl<T> PointSampler<T> {
    pub(super) fn try_map<U, E>(
        &self,
        name: &str,
        f: &mut impl FnMut(&str, &T) -> Result<U, E>,
    ) -> Result<PointSampler<U>, E> {
        let layers = self.dev_convs.iter().enumerate();
        Ok(PointSampler {
            dev_convs: layers.map(|(i, l)| l.try_map(&format!("{name}.dev_conv_{i}"), f)).collect::<Result<_, _>>()?,
            score: self.score.try_map(&format!("{name}.score"), f)?,
        })
    }
}
