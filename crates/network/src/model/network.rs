//! The three stages together, and the traversal of their tensors.

use super::{EdgePredictor, FaceClassifier, PointSampler};
use crate::autodiff::{Tensors, WeightsError};
use std::convert::Infallible;

/// The paper's network; `T` is a shape, a matrix, or a value on a tape.
#[derive(Clone, Debug, PartialEq)]
pub struct Network<T> {
    /// Point Sampler, Sec. 3.1.
    pub point_sampler: PointSampler<T>,
    /// Edge Predictor, Sec. 3.2.
    pub edge_predictor: EdgePredictor<T>,
    /// Face Classifier, Sec. 3.3.
    pub face_classifier: FaceClassifier<T>,
}

impl<T> Network<T> {
    /// Applies `f(name, tensor)` to every tensor in a fixed order, until `f` fails.
    pub fn try_map<U, E>(&self, mut f: impl FnMut(&str, &T) -> Result<U, E>) -> Result<Network<U>, E> {
        Ok(Network {
            point_sampler: self.point_sampler.try_map("point_sampler", &mut f)?,
            edge_predictor: self.edge_predictor.try_map("edge_predictor", &mut f)?,
            face_classifier: self.face_classifier.try_map("face_classifier", &mut f)?,
        })
    }

    /// Applies `f(name, tensor)` to every tensor in a fixed order.
    ///
    /// ```
    /// # use neural_mesh_network as neural_mesh;
    /// use neural_mesh::model::Architecture;
    /// let mut names = Vec::new();
    /// Architecture::default().shapes().map(|name, _| names.push(name.to_string()));
    /// assert_eq!(names[0], "point_sampler.dev_conv_0.theta");
    /// ```
    pub fn map<U>(&self, mut f: impl FnMut(&str, &T) -> U) -> Network<U> {
        match self.try_map(|name, tensor| Ok::<U, Infallible>(f(name, tensor))) {
            Ok(network) => network,
            Err(never) => match never {},
        }
    }

    /// Builds the network from its tensors by name.
    ///
    /// # Errors
    /// [`WeightsError::Missing`] names the first missing tensor.
    pub fn with_tensors<U: Clone>(&self, tensors: &Tensors<U>) -> Result<Network<U>, WeightsError> {
        self.try_map(|name, _| tensors.find_tensor(name).cloned())
    }
}

impl<T: Clone> Network<T> {
    /// Returns the tensors by name, in the order of [`Self::map`].
    ///
    /// ```
    /// # use neural_mesh_network as neural_mesh;
    /// use neural_mesh::model::Architecture;
    /// let shapes = Architecture::default().shapes();
    /// assert_eq!(shapes.with_tensors(&shapes.named_tensors()), Ok(shapes));
    /// ```
    pub fn named_tensors(&self) -> Tensors<T> {
        let mut tensors = Tensors::default();
        self.map(|name, tensor| tensors.push(name, tensor.clone()));
        tensors
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::autodiff::test_gradients::check_gradients;
    use crate::autodiff::{Tape, Value};
    use crate::linalg::test_values::random;
    use crate::linalg::{Csr, Matrix};
    use crate::model::{
        Architecture, Vertices, Weights, candidate_faces, edge_predictor, extended_graph, face_classifier,
        point_sampler, prior, triangle_graph,
    };
    use std::sync::Arc;

    const SIZES: Architecture = Architecture::TINY;

    fn points() -> Vec<[f32; 3]> {
        random(14, 3, 3).data().as_chunks().0.to_vec()
    }

    fn matrices(weights: &Weights) -> Vec<Matrix> {
        let mut matrices = Vec::new();
        weights.tensors().map(|_, matrix| matrices.push(matrix.as_ref().clone()));
        matrices
    }

    fn network_of_values(weights: &Weights, values: &[Value]) -> Network<Value> {
        let mut next = values.iter();
        weights.tensors().map(|_, _| next.next().unwrap().clone())
    }

    fn ring(n: usize) -> Arc<Csr> {
        let n = n as u32;
        Csr::from_edges(n as usize, (0..n).flat_map(|i| [[i, (i + 1) % n], [i, (i + 2) % n]])).into()
    }

    #[test]
    fn gradients_of_the_point_sampler() {
        let rings = ring(14);
        for point_sampler_layers in [1, 2] {
            let weights = Weights::random_of(Architecture { point_sampler_layers, ..SIZES }, 2);
            let of_vertices = vec![Matrix::from_points(&points()), random(14, 3, 8)];
            check_gradients(&[matrices(&weights), of_vertices].concat(), |tape, values| {
                let (tensors, [points, normals]) = values.split_last_chunk().unwrap();
                let vertices = Vertices { points, normals: Some(normals) };
                point_sampler(tape, &network_of_values(&weights, tensors).point_sampler, vertices, &rings)
            });
        }
    }

    #[test]
    fn gradients_of_edge_predictor_prior_and_face_classifier_together() {
        let weights = Weights::random_of(SIZES, 3);
        let (points, original) = (points(), ring(14));
        let graph = Arc::new(extended_graph(&points, &original, SIZES.edge_knn));
        let candidates = candidate_faces(&graph, &vec![1.0; graph.n_entries()], &[]);
        let triangles = Arc::new(triangle_graph(&points, &candidates.triangles, SIZES.face_knn));
        check_gradients(&matrices(&weights), |tape, values| {
            let net = network_of_values(&weights, values);
            let samples = Value::constant(Matrix::from_points(&points));
            let edges = edge_predictor(tape, &net.edge_predictor, &samples, &graph, &original);
            let prior = prior(tape, &edges.adjacency, &candidates);
            face_classifier(tape, &net.face_classifier, &samples, &candidates.triangles, &triangles, &prior)
        });
    }

    #[test]
    fn inference_records_nothing() {
        let net = Weights::random_of(SIZES, 2).constants();
        let mut tape = Tape::default();
        let points = Value::constant(Matrix::from_points(&points()));
        let vertices = Vertices { points: &points, normals: None };
        assert!(point_sampler(&mut tape, &net.point_sampler, vertices, &ring(14)).is_constant());
        assert!(edge_predictor(&mut tape, &net.edge_predictor, &points, &ring(14), &ring(14)).adjacency.is_constant());
        assert!(tape.is_empty());
    }
}
