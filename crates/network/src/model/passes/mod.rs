//! Forward and backward passes of each stage and of the whole network, over slices; "gradient by x" means with respect
//! to x.
//!
//! A backward function turns a loss's gradients by results into those by tensors and positions; graphs and candidates
//! are constants.

mod edge_predictor;
mod face_classifier;
mod point_sampler;
mod whole;

pub use edge_predictor::{EdgePredictorGradients, EdgePredictorPass, edge_predictor_backward, edge_predictor_forward};
pub use face_classifier::{
    FaceClassifierGradients, FaceClassifierPass, face_classifier_backward, face_classifier_forward,
};
pub use point_sampler::{PointSamplerGradients, PointSamplerPass, point_sampler_backward, point_sampler_forward};
pub use whole::{Connectivity, NetworkGradients, NetworkPass, Outputs, network_backward, network_forward};

use crate::autodiff::{Gradients, Value};
use crate::linalg::Matrix;

fn gradient_of_points(gradients: &Gradients, points: &Value) -> Vec<[f32; 3]> {
    gradients.or_zero(points).data().as_chunks().0.to_vec()
}

fn column(values: &[f32]) -> Matrix {
    Matrix::new(values.len(), 1, values.to_vec())
}

fn numbers(value: &Value) -> Vec<f32> {
    value.matrix().data().to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::Csr;
    use crate::linalg::test_values::random;
    use crate::model::{
        Architecture, PredictedEdges, Weights, candidate_faces, extended_graph, predict_edges, predict_faces,
        triangle_graph, vertex_scores,
    };
    use std::sync::Arc;

    const N: usize = 30;
    const SAMPLES: [u32; 14] = [0, 2, 3, 5, 6, 9, 12, 15, 17, 18, 20, 23, 26, 29];

    fn weights() -> Weights {
        Weights::random_of(Architecture::TINY, 3)
    }

    fn points() -> Vec<[f32; 3]> {
        random(N, 3, 3).data().as_chunks().0.to_vec()
    }

    fn normals() -> Vec<[f32; 3]> {
        random(N, 3, 7).data().as_chunks().0.to_vec()
    }

    fn gather(points: &[[f32; 3]]) -> Vec<[f32; 3]> {
        SAMPLES.iter().map(|&v| points[v as usize]).collect()
    }

    fn ring(n: usize) -> Arc<Csr> {
        let n = n as u32;
        Csr::from_edges(n as usize, (0..n).flat_map(|i| [[i, (i + 1) % n], [i, (i + 2) % n]])).into()
    }

    fn connectivity(weights: &Weights, points: &[[f32; 3]]) -> Connectivity {
        let (sampled, original) = (gather(points), ring(SAMPLES.len()));
        let graph = Arc::new(extended_graph(&sampled, &original, weights.architecture().edge_knn));
        let candidates = candidate_faces(&graph, &vec![1.0; graph.n_entries()], &[]).in_coherent_order(&sampled);
        let triangle_graph = triangle_graph(&sampled, &candidates.triangles, weights.architecture().face_knn).into();
        let (rings, normals) = (ring(N), Some(normals()));
        Connectivity { rings, normals, samples: SAMPLES.into(), original, graph, candidates, triangle_graph }
    }

    fn list(n: usize, seed: u64) -> Vec<f32> {
        random(n, 1, seed).into_data()
    }

    fn dot(a: &[f32], b: &[f32]) -> f64 {
        assert_eq!(a.len(), b.len());
        a.iter().zip(b).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum()
    }

    /// Panics unless most entries of the gradient match central differences of `loss`.
    fn assert_gradient(x: &[f32], gradient: &[f32], loss: impl Fn(&[f32]) -> f64) {
        let scale = gradient.iter().fold(0.0, |most: f32, g| most.max(g.abs()));
        let error = |at: usize| {
            let moved = |step: f32| {
                let mut x = x.to_vec();
                x[at] += step;
                loss(&x)
            };
            let numeric = (moved(5e-4) - moved(-5e-4)) / 1e-3;
            (numeric - f64::from(gradient[at])).abs() / f64::from(scale)
        };
        let mut errors: Vec<f64> = (0..x.len()).map(error).collect();
        errors.sort_by(f64::total_cmp);
        let median = errors[errors.len() / 2];
        assert!(scale > 0.0 && median < 2e-3, "median of the relative errors {median}");
    }

    fn as_points(x: &[f32]) -> &[[f32; 3]] {
        x.as_chunks().0
    }

    #[test]
    fn the_point_sampler_is_that_of_inference_and_its_gradients_are_slopes() {
        let (weights, points, normals, rings) = (weights(), points(), normals(), ring(N));
        let pass = point_sampler_forward(&weights, &points, Some(&normals), &rings);
        assert_eq!(pass.scores, vertex_scores(&weights, &points, Some(&normals), &rings));
        let g = list(N, 5);
        let gradients = point_sampler_backward(&pass, &g);
        assert_gradient(points.as_flattened(), gradients.points.as_flattened(), |x| {
            dot(&point_sampler_forward(&weights, as_points(x), Some(&normals), &rings).scores, &g)
        });
        assert_gradient(normals.as_flattened(), gradients.normals.as_flattened(), |x| {
            dot(&point_sampler_forward(&weights, &points, Some(as_points(x)), &rings).scores, &g)
        });
    }

    #[test]
    fn the_edge_predictor_is_that_of_inference_and_its_gradients_are_slopes() {
        let (weights, points) = (weights(), gather(&points()));
        let original = ring(SAMPLES.len());
        let PredictedEdges { graph, attention, adjacency } = predict_edges(&weights, &points, &original);
        let pass = edge_predictor_forward(&weights, &points, &graph, &original);
        assert_eq!((&pass.attention, &pass.adjacency), (&attention, &adjacency));
        let [g, h] = [6, 7].map(|seed| list(graph.n_entries(), seed));
        let gradients = edge_predictor_backward(&pass, &g, &h);
        assert_gradient(points.as_flattened(), gradients.points.as_flattened(), |x| {
            let pass = edge_predictor_forward(&weights, as_points(x), &graph, &original);
            dot(&pass.attention, &g) + dot(&pass.adjacency, &h)
        });
    }

    #[test]
    fn the_face_classifier_is_that_of_inference_and_its_gradients_are_slopes() {
        let (weights, points) = (weights(), gather(&points()));
        let edges = predict_edges(&weights, &points, &ring(SAMPLES.len()));
        let faces = predict_faces(&weights, &points, &edges, &[]);
        let triangles = &faces.candidates.triangles;
        let graph = triangle_graph(&points, triangles, weights.architecture().face_knn).into();
        let pass = face_classifier_forward(&weights, &points, triangles, &graph, &faces.prior);
        assert_eq!(pass.probabilities, faces.probabilities);
        let g = list(triangles.len(), 8);
        let gradients = face_classifier_backward(&pass, &g);
        let x = [points.as_flattened(), &faces.prior].concat();
        let gradient = [gradients.points.as_flattened(), &gradients.prior].concat();
        assert_gradient(&x, &gradient, |x| {
            let (points, prior) = x.split_at(3 * points.len());
            dot(&face_classifier_forward(&weights, as_points(points), triangles, &graph, prior).probabilities, &g)
        });
    }

    #[test]
    fn the_whole_is_its_stages_and_its_gradients_are_slopes() {
        let (weights, points) = (weights(), points());
        let chosen = connectivity(&weights, &points);
        let pass = network_forward(&weights, &points, &chosen);
        let (n_entries, n_candidates) = (chosen.graph.n_entries(), chosen.candidates.triangles.len());
        let g = Outputs {
            scores: list(N, 1),
            attention: list(n_entries, 2),
            adjacency: list(n_entries, 3),
            prior: Vec::new(),
            probabilities: list(n_candidates, 4),
        };
        let gradients = network_backward(&pass, &g);
        assert_gradient(points.as_flattened(), gradients.points.as_flattened(), |x| {
            let Outputs { scores, attention, adjacency, probabilities, .. } =
                network_forward(&weights, as_points(x), &chosen).outputs;
            dot(&scores, &g.scores)
                + dot(&attention, &g.attention)
                + dot(&adjacency, &g.adjacency)
                + dot(&probabilities, &g.probabilities)
        });
        let pass = point_sampler_forward(&weights, &points, chosen.normals.as_deref(), &chosen.rings);
        let sampler = point_sampler_backward(&pass, &g.scores);
        assert_eq!(gradients.tensors.point_sampler, sampler.tensors);
    }

    #[test]
    fn gradients_have_the_same_bits_on_any_number_of_threads() {
        let (weights, points) = (weights(), points());
        let chosen = connectivity(&weights, &points);
        let on_threads = |n| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
            let probabilities = list(chosen.candidates.triangles.len(), 4);
            let gradient = Outputs { scores: list(N, 1), probabilities, ..Outputs::default() };
            pool.install(|| network_backward(&network_forward(&weights, &points, &chosen), &gradient))
        };
        let one = on_threads(1);
        assert_eq!(one, on_threads(2));
        assert_eq!(one, on_threads(8));
    }
}
