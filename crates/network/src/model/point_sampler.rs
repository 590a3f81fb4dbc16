//! Point Sampler, Sec. 3.1.

use super::dev_conv::dev_conv_with_normals;
use super::{Affine, DevConv, dev_conv};
use crate::autodiff::{Tape, Value};
use crate::linalg::{Csr, Matrix};
use std::sync::Arc;

/// DevConv layers, an optional hidden layer, and a linear map to one score.
#[derive(Clone, Debug, PartialEq)]
pub struct PointSampler<T> {
    /// DevConv layers in order; the first acts on positions, or on positions and normals.
    pub dev_convs: Vec<DevConv<T>>,
    /// Hidden layer with ReLU before the score; without it, scaled inputs scale all score differences alike.
    pub hidden: Option<Affine<T>>,
    /// Map from the last features to the score.
    pub score: Affine<T>,
}

/// Inputs of the Point Sampler per vertex.
#[derive(Clone, Copy, Debug)]
pub struct Vertices<'a> {
    /// n x 3, from [`in_edge_lengths`](super::in_edge_lengths).
    pub points: &'a Value,
    /// n x 3, unit vectors, zero if missing; only for networks with 6 inputs.
    pub normals: Option<&'a Value>,
}

/// Scores every vertex; higher scores are sampled sooner, and only differences between scores matter.
///
/// # Shapes
/// - `vertices`: n rows
/// - `rings`: n x n, the edges of the mesh
/// - returns n x 1
///
/// ```
/// # use neural_mesh_network as neural_mesh;
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
        // Only a first layer over positions and normals has more weight rows than the positions have columns.
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

/// Computes the softmax of the scores, n x 1: the probabilities of a multinomial distribution over the mesh.
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::{autodiff::{Tape, Value}, linalg::Matrix, model::inclusion_probabilities};
/// let scores = Value::constant(Matrix::new(2, 1, vec![7.0, 7.0]));
/// assert_eq!(inclusion_probabilities(&mut Tape::default(), &scores).matrix().data(), [0.5, 0.5]);
/// ```
pub fn inclusion_probabilities(tape: &mut Tape, scores: &Value) -> Value {
    tape.softmax(scores)
}

impl<T> PointSampler<T> {
    /// Applies `f(name, tensor)` to every tensor in a fixed order, until `f` fails; names begin with `name`.
    ///
    /// ```
    /// # use neural_mesh_network as neural_mesh;
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
