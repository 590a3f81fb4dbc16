//! Face Classifier, Sec. 3.3.

use super::candidate_faces::{barycenters, join_across_edges};
use super::tri_conv::{Layers, tri_convs};
use super::{Affine, TriConv, triangle_positions};
use crate::autodiff::{Tape, Value};
use crate::linalg::Csr;
use crate::parallel;
use crate::spatial::nearest_neighbours;
use rayon::prelude::*;
use std::sync::Arc;

/// TriConv layers and a linear map to one number.
#[derive(Clone, Debug, PartialEq)]
pub struct FaceClassifier<T> {
    /// TriConv layers in order; the first acts on the prior.
    pub tri_convs: Vec<TriConv<T>>,
    /// Map from the last features to a triangle's logit.
    pub output: Affine<T>,
}

/// Joins every triangle with the k others of nearest barycenter, or with edge neighbours if k is 0: G_tri, without loops.
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::model::triangle_graph;
/// let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [9.0, 9.0, 0.0]];
/// let graph = triangle_graph(&points, &[[0, 1, 2], [1, 2, 3], [0, 1, 3]], 1);
/// assert_eq!((graph.row(0), graph.row(1)), ([2].as_slice(), [2].as_slice()));
/// // The edges 1-2 and 0-1.
/// let across = triangle_graph(&points, &[[0, 1, 2], [1, 2, 3], [0, 1, 3]], 0);
/// assert_eq!((across.row(0), across.row(1)), ([1, 2].as_slice(), [0, 2].as_slice()));
/// ```
pub fn triangle_graph(points: &[[f32; 3]], triangles: &[[u32; 3]], k: usize) -> Csr {
    if k == 0 {
        return across_edges(triangles);
    }
    let neighbours = nearest_neighbours(&barycenters(points, triangles), k);
    let k = neighbours.len() / triangles.len().max(1);
    Csr::from_equal_rows(triangles.len(), triangles.len(), k, neighbours)
}

fn across_edges(triangles: &[[u32; 3]]) -> Csr {
    let ends = |&[i, j, k]: &[u32; 3]| [[i, j], [i, k], [j, k]].map(|[a, b]| [a.min(b), a.max(b)]);
    let mut edges: Vec<[u32; 2]> = triangles.iter().flat_map(ends).collect();
    edges.par_sort_unstable();
    edges.dedup();
    let number = |edge: [u32; 2]| edges.partition_point(|other| *other < edge) as u32;
    let numbered = parallel::map(triangles.len(), 256, |t| ends(&triangles[t]).map(number));
    join_across_edges(&numbered, edges.len())
}

/// Computes the probability of each candidate face: TriConv layers over its prior, then a sigmoid.
///
/// The paper's softmax over all triangles would give at most one a probability above one half.
///
/// # Shapes
/// - `points`: n x 3, the samples, scaled to mean edge length 1
/// - `triangles`: corners ascending by original vertex
/// - `graph`: G_tri
/// - `prior` and the result: n_triangles x 1
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::{autodiff::{Tape, Value}, linalg::Matrix, model::{Weights, face_classifier, triangle_graph}};
/// let weights = Weights::random(1);
/// let points = [[0.0; 3], [0.5, 0.0, 0.0], [0.0, 0.5, 0.0], [0.5, 0.5, 0.0]];
/// let triangles = [[0, 1, 2], [1, 2, 3]];
/// let graph = triangle_graph(&points, &triangles, 20).into();
/// let prior = Value::constant(Matrix::new(2, 1, vec![0.5, 0.25]));
/// let points = Value::constant(Matrix::from_points(&points));
/// let net = weights.constants().face_classifier;
/// let probabilities = face_classifier(&mut Tape::default(), &net, &points, &triangles, &graph, &prior);
/// assert!(probabilities.matrix().data().iter().all(|p| (0.0..=1.0).contains(p)));
/// ```
pub fn face_classifier(
    tape: &mut Tape,
    net: &FaceClassifier<Value>,
    points: &Value,
    triangles: &[[u32; 3]],
    graph: &Arc<Csr>,
    prior: &Value,
) -> Value {
    let positions = triangle_positions(tape, points, triangles);
    let layers = Layers { tri_convs: &net.tri_convs, last: &net.output };
    let logits = tri_convs(tape, layers, &positions, prior, graph);
    tape.sigmoid(&logits)
}

impl<T> FaceClassifier<T> {
    /// Applies `f(name, tensor)` to every tensor in a fixed order, until `f` fails; names begin with `name`.
    ///
    /// ```
    /// # use neural_mesh_network as neural_mesh;
    /// use neural_mesh::model::Architecture;
    /// let mut names = Vec::new();
    /// let stage = Architecture::default().shapes().face_classifier;
    /// stage.try_map("classifier", &mut |name, _| Ok::<_, ()>(names.push(name.to_string()))).unwrap();
    /// assert_eq!(names[0], "classifier.tri_conv_0.hidden.weights");
    /// ```
    pub fn try_map<U, E>(
        &self,
        name: &str,
        f: &mut impl FnMut(&str, &T) -> Result<U, E>,
    ) -> Result<FaceClassifier<U>, E> {
        let layers = self.tri_convs.iter().enumerate();
        Ok(FaceClassifier {
            tri_convs: layers.map(|(i, l)| l.try_map(&format!("{name}.tri_conv_{i}"), f)).collect::<Result<_, _>>()?,
            output: self.output.try_map(&format!("{name}.output"), f)?,
        })
    }
}
