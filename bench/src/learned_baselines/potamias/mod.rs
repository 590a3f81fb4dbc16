//! Simplified point clouds: "Revisiting Point Cloud Simplification: A Learnable Feature Preserving Approach" (Potamias,
//! Bouritsas, Zafeiriou, ECCV 2022).
//!
//! Layers and widths are those of the Point Sampler; the text at hand gives none.

mod adaptive_chamfer;
mod cloud;
mod curvature_preservation;
mod latent_likeness;
mod network;
mod projection;
mod refinement;
mod selection;
mod step;

use super::compact_with_first_point;
use crate::baselines::ball_pivoting;
use anyhow::Result;
use neural_mesh::autodiff::{Tape, Tensors};
use neural_mesh::linalg::Matrix;
use neural_mesh::mesh::{TriMesh, compact, vertex_normals};
use neural_mesh::spatial::nearest_to;
use std::sync::Arc;

pub use network::shapes;
pub use step::potamias_step;

use adaptive_chamfer::{adaptive_chamfer, adaptive_weights};
use cloud::Cloud;
use curvature_preservation::{curvature_preservation, mean_curvature};
use latent_likeness::latent_likeness;
use projection::projection;
use refinement::refinement;
use selection::selection;

/// A loss of points and its gradient.
#[derive(Clone, Debug, PartialEq)]
pub struct PointLoss {
    /// Value.
    pub value: f64,
    /// Derivative by each point, n x 3.
    pub gradient: Vec<[f64; 3]>,
}

/// Simplifies a cloud to at most `n` points, which may differ from the input's.
///
/// # Shapes
/// - `points`: n_points x 3, finite; `first`: index of the point drawn first
///
/// # Panics
/// If tensors are missing or have wrong shapes, or `first` does not exist.
pub fn simplify_points(points: &[[f32; 3]], n: usize, first: u32, tensors: &Tensors<Arc<Matrix>>) -> Vec<[f32; 3]> {
    let Some(cloud) = Cloud::new(points) else { return points[..n.min(points.len())].to_vec() };
    let tensors = tensors.constants();
    let tape = &mut Tape::default();
    let latent = projection(tape, &tensors, &cloud);
    let samples = selection(&cloud, latent.matrix(), n, first);
    let refinement = refinement(tape, &tensors, &cloud, &latent, &samples);
    cloud.to_input(&refinement.points())
}

pub(super) fn simplify(
    mesh: &TriMesh,
    n_vertices: usize,
    seed: u64,
    tensors: &Tensors<Arc<Matrix>>,
) -> Result<TriMesh> {
    let (mesh, first) = compact_with_first_point(mesh, seed)?;
    let vertices = mesh.positions();
    let points = simplify_points(vertices, n_vertices, first, tensors);
    let all = vertex_normals(&mesh);
    let normals: Vec<[f32; 3]> = nearest_to(vertices, &points, 1).iter().map(|&v| all[v as usize]).collect();
    Ok(compact(&points, ball_pivoting(&points, &normals))?.0)
}

#[cfg(test)]
mod tests {
    // Networks are compared with NumPy (`bench/tests/golden/potamias.py`), gradients with differences.

    use super::*;
    use crate::autodiff::test_gradients::check_gradients;
    use crate::learned_baselines::LearnedBaseline;
    use crate::learned_baselines::tests::{assert_near, tensors_by_formula, with_names};

    // Layers are 4 wide, with one latent number.
    const SHARE: f64 = 1.0 / 16.0;
    const SAMPLES: [u32; 3] = [2, 5, 13];

    const LATENT: [f64; 6] = [1.65929, 1.55651, 1.52211, 2.23474, 2.24178, 2.04842];
    const REFINED: [[f64; 3]; 3] = [
        [-0.5599889294200273, 0.20998400401990291, 1.247924658836765],
        [-1.5203990638456941, 0.41246755746078845, -0.37758328503963456],
        [-2.624906482413783, 0.7055579677068253, -0.7899313552645141],
    ];

    fn cloud() -> Cloud {
        let point = |i: usize| {
            let i = i as f64;
            [(1.3 * i).sin(), (0.7 * i).cos(), (0.4 * i * i).sin()].map(|x| x as f32)
        };
        Cloud::new(&(0..20).map(point).collect::<Vec<_>>()).unwrap()
    }

    fn tensors() -> Tensors<Arc<Matrix>> {
        tensors_by_formula(&shapes(SHARE), |number, [i, j], _| (1.0 + 1.7 * number + 0.9 * i + 2.3 * j).sin())
    }

    #[test]
    fn projection_and_refinement_agree_with_numpy() {
        let (cloud, tensors) = (cloud(), tensors().constants());
        let tape = &mut Tape::default();
        let latent = projection(tape, &tensors, &cloud);
        assert_near(&latent.matrix().data()[..6], &LATENT);
        let refined = refinement(tape, &tensors, &cloud, &latent, &SAMPLES).points();
        assert_near(refined.as_flattened(), REFINED.as_flattened());
        assert!(tape.is_empty());
    }

    #[test]
    fn gradients_of_projection_and_refinement() {
        let (cloud, shapes) = (cloud(), shapes(SHARE));
        let matrices: Vec<Matrix> = shapes.draw(3).iter().map(|(_, matrix)| matrix.as_ref().clone()).collect();
        check_gradients(&matrices, |tape, values| {
            let named = with_names(&shapes, values);
            let latent = projection(tape, &named, &cloud);
            refinement(tape, &named, &cloud, &latent, &SAMPLES).displacement
        });
    }

    #[test]
    fn points_follow_the_cloud_wherever_it_is() {
        let sphere = neural_mesh::mesh::shapes::wavy_sphere(3, 4.0);
        let tensors = LearnedBaseline::Potamias.initial_tensors(0.25, 1);
        let moved: Vec<[f32; 3]> =
            sphere.positions().iter().map(|p| [4.0 * p[0] + 8.0, 4.0 * p[1] - 16.0, 4.0 * p[2] + 32.0]).collect();
        let [here, there] = [sphere.positions(), &moved].map(|points| simplify_points(points, 60, 5, &tensors));
        let back = there.iter().map(|p| [p[0] - 8.0, p[1] + 16.0, p[2] - 32.0].map(|x| 0.25 * x));
        let near = here.iter().zip(back).filter(|(a, b)| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-4)).count();
        // Rounding may change a choice.
        assert!(near > 54, "{near}");
    }

    #[test]
    fn few_points_stay_as_they_are() {
        let tensors = LearnedBaseline::Potamias.initial_tensors(0.25, 1);
        assert!(simplify_points(&[], 3, 0, &tensors).is_empty());
        assert_eq!(simplify_points(&[[1.0; 3]; 5], 3, 0, &tensors), [[1.0; 3]; 3]);
        assert_eq!(simplify_points(&[[0.0; 3], [1.0; 3]], 9, 0, &tensors).len(), 2);
    }
}
