//! Gradient of the terms over faces by the scores, through the draw of the samples (Sec. 3.1, "end-to-end").

use super::{Inclusion, inclusion_gradient};

/// Faces over drawn samples, with their probabilities.
#[derive(Clone, Copy, Debug)]
pub struct DrawnFaces<'a> {
    /// Drawn vertices, n_samples.
    pub samples: &'a [u32],
    /// Samples at the corners of each face, n_faces x 3.
    pub faces: &'a [[u32; 3]],
    /// Probability of each face, n_faces.
    pub probabilities: &'a [f32],
}

/// Converts the gradient to the probabilities of faces into a gradient to the scores.
///
/// Straight through: each probability counts as multiplied by `pi / pi` of its three corners, 1 in value, with only the
/// numerators, the inclusion probabilities of [`inclusion`](super::inclusion), differentiable.
///
/// # Shapes
/// - `gradient`: n_faces
/// - returns n_vertices
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::loss::{DrawnFaces, gradient_through_draw, inclusion};
/// let drawn = DrawnFaces { samples: &[0, 1, 3], faces: &[[0, 1, 2]], probabilities: &[0.5] };
/// // More of the face lowers the loss, and the vertex without a part in it loses score.
/// let to_scores = gradient_through_draw(&drawn, &[-1.0], &inclusion(&[0.0; 4], 3));
/// assert!(to_scores[0] < 0.0 && to_scores[1] == to_scores[3] && to_scores[2] > 0.0);
/// ```
pub fn gradient_through_draw(drawn: &DrawnFaces, gradient: &[f32], inclusion: &Inclusion) -> Vec<f32> {
    let mut to_inclusion = vec![0.0f32; inclusion.probabilities.len()];
    for ((face, &p), &g) in drawn.faces.iter().zip(drawn.probabilities).zip(gradient) {
        for vertex in face.map(|sample| drawn.samples[sample as usize] as usize) {
            to_inclusion[vertex] += g * p / inclusion.probabilities[vertex].max(LEAST);
        }
    }
    inclusion_gradient(inclusion, &to_inclusion)
}

/// Least inclusion probability that divides, so that a drawn vertex of probability 0 has no infinite gradient.
const LEAST: f32 = 1e-12;

#[cfg(test)]
mod tests {
    use super::super::test_gradients::{assert_gradient, uniform};
    use super::super::{Term, conflicts_by_pair, inclusion};
    use super::*;

    #[test]
    fn gradient_agrees_with_differences_of_the_gated_loss() {
        let (samples, faces) = ([1u32, 4, 5, 8, 9], [[0, 1, 2], [1, 2, 3], [0, 3, 4], [2, 3, 4]]);
        let probabilities = uniform(4, 3);
        let scores: Vec<f32> = uniform(12, 5).iter().map(|x| 3.0 * x).collect();
        let fixed = inclusion(&scores, 5).probabilities;
        assert_gradient(&scores, 2e-3, |scores| {
            let included = inclusion(scores, 5);
            let gate = |sample: u32| {
                let vertex = samples[sample as usize] as usize;
                included.probabilities[vertex] / fixed[vertex]
            };
            let gates = faces.map(|face: [u32; 3]| face.map(gate).iter().product::<f32>());
            let gated: Vec<f32> = probabilities.iter().zip(gates).map(|(p, gate)| p * gate).collect();
            let loss = conflicts_by_pair(&[[0, 1], [1, 3], [2, 3], [3, 0]], &gated);
            let drawn = DrawnFaces { samples: &samples, faces: &faces, probabilities: &gated };
            Term { value: loss.value, gradient: gradient_through_draw(&drawn, &loss.gradient, &included) }
        });
    }
}
