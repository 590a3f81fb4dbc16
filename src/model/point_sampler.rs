//! The Point Sampler, Sec. 3.1: a score for every vertex, and the multinomial distribution that the scores are.

use super::dev_conv::dev_conv_with_normals;
use super::{Affine, DevConv, dev_conv};
use crate::autodiff::{Tape, Value};
use crate::linalg::{Csr, Matrix};
use std::sync::Arc;

/// Stacked DevConv layers and a linear map to one score, as in the paper; with a hidden layer between them where the
/// sizes ask for one.
#[derive(Clone, Debug, PartialEq)]
pub struct PointSampler<T> {
    /// The layers, the first over positions, or over positions and normals.
    pub dev_convs: Vec<DevConv<T>>,
    /// width to hidden width, then ReLU. DevConv has no bias, so without this a score grows in proportion to what it
    /// sees and cannot level off.
    pub hidden: Option<Affine<T>>,
    /// To 1.
    pub score: Affine<T>,
}

/// What the Point Sampler sees of the vertices.
#[derive(Clone, Copy, Debug)]
pub struct Vertices<'a> {
    /// n x 3, from [`in_edge_lengths`](super::in_edge_lengths).
    pub points: &'a Value,
    /// n x 3, unit vectors; looked at only by a network whose sizes ask for them, and zero for it where there are none.
    pub normals: Option<&'a Value>,
}

/// Scores every vertex; larger ones are sampled sooner. Any number; only differences of scores matter.
///
/// # Shapes
/// - `vertices`: n rows
/// - `rings`: n x n, the edges of the mesh
/// - returns n x 1
///
/// ```
/// use neural_mesh::{autodiff::{Tape, Value}, linalg::{Csr, Matrix}, model::{Vertices, Weights, point_sampler}};
/// let weights = Weights::random(1);
/// let points = Value::constant(Matrix::new(2, 3, vec![0.0, 0.0, 0.0, 0.5, 0.0, 0.0]));
/// let vertices = Vertices { points: &points, normals: None };
/// let rings = Csr::from_edges(2, [[0, 1]]).into();
/// let scores = point_sampler(&mut Tape::default(), &weights.constants().point_sampler, vertices, &rings);
/// assert_eq!(scores.matrix().shape(), [2, 1]);
/// ```
pub fn point_sampler(tape: &mut Tape, net: &PointSampler<Value>, vertices: Vertices, rings: &Arc<Csr>) -> Value {
    let score = [&net.score.weights, &net.score.bias];
    let none = || Value::constant(Matrix::zeros(vertices.points.matrix().n_rows(), 3));
    if let ([layer], Some(hidden)) = (net.dev_convs.as_slice(), &net.hidden)
        && layer.theta.matrix().n_rows() == 6
    {
        let normals = vertices.normals.cloned().unwrap_or_else(none);
        let layers = [[&hidden.weights, &hidden.bias], score];
        return tape.scored_dev_conv([vertices.points, &normals], rings, [&layer.theta, &layer.phi], layers);
    }
    let mut features = vertices.points.clone();
    for layer in &net.dev_convs {
        // The first layer alone can be wider than what it is given.
        features = if layer.theta.matrix().n_rows() > features.matrix().n_cols() {
            let normals = vertices.normals.cloned().unwrap_or_else(none);
            dev_conv_with_normals(tape, layer, [&features, &normals], rings)
        } else {
            dev_conv(tape, layer, &features, rings)
        };
    }
    match &net.hidden {
        Some(hidden) => tape.two_layers(&features, [&hidden.weights, &hidden.bias], score),
        None => tape.affine(&features, score[0], score[1]),
    }
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
    /// Applies `f(name, tensor)` to every tensor, in a fixed order, as [`Network::try_map`](super::Network::try_map) does;
    /// names begin with `name`.
    ///
    /// # Errors
    /// The first error of `f`.
    ///
    /// ```
    /// use neural_mesh::model::Architecture;
    /// let mut names = Vec::new();
    /// let stage = Architecture::default().shapes().point_sampler;
    /// stage.try_map("sampler", &mut |name, _| Ok::<_, ()>(names.push(name.to_string()))).unwrap();
    /// assert_eq!(names[0], "sampler.dev_conv_0.theta");
    /// ```
    pub fn try_map<U, E>(
        &self,
        name: &str,
        f: &mut impl FnMut(&str, &T) -> Result<U, E>,
    ) -> Result<PointSampler<U>, E> {
        let layers = self.dev_convs.iter().enumerate();
        Ok(PointSampler {
            dev_convs: layers.map(|(i, l)| l.try_map(&format!("{name}.dev_conv_{i}"), f)).collect::<Result<_, _>>()?,
            hidden: self.hidden.as_ref().map(|l| l.try_map(&format!("{name}.hidden"), f)).transpose()?,
            score: self.score.try_map(&format!("{name}.score"), f)?,
        })
    }
}
