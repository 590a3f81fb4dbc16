//! Simplified clouds of points: "Revisiting Point Cloud Simplification: A Learnable Feature Preserving Approach" (Potamias,
//! Bouritsas, Zafeiriou, ECCV 2022).
//!
//! A network projects each point with its neighbourhood into a latent space, farthest points are drawn there, and an
//! attention over the neighbours of each moves it. The result is meshed by ball pivoting, as a row of the paper's Table 1.
//!
//! The parts and the 15 neighbours are theirs. Widths, depth and the precise form of the layers are not in the text at hand:
//! they are those of the Point Sampler, by the same authors, 64 wide in three layers. What else was decided stands in each
//! file.

mod adaptive_chamfer;
mod cloud;
mod curvature_preservation;
mod latent_likeness;
mod network;
mod projection;
mod refinement;
mod selection;
#[cfg(test)]
mod test_golden;

use super::LearnedBaselineError;
use crate::autodiff::{Tape, Tensors};
use crate::linalg::Matrix;
use crate::mesh::{TriMesh, compact, vertex_normals};
use crate::spatial::{ball_pivoting, nearest_to};
use std::sync::Arc;

pub use adaptive_chamfer::{adaptive_chamfer, adaptive_weights};
pub use cloud::{Cloud, NEIGHBOURS};
pub use curvature_preservation::{curvature_preservation, mean_curvature};
pub use latent_likeness::latent_likeness;
pub use network::{Potamias, drawn, shapes};
pub use projection::projection;
pub use refinement::{Refinement, refinement};
pub use selection::selection;

/// A loss of points and its gradient to each of them.
#[derive(Clone, Debug, PartialEq)]
pub struct PointLoss {
    /// The loss.
    pub value: f64,
    /// n x 3.
    pub gradient: Vec<[f64; 3]>,
}

/// Simplifies a cloud to `n` points, which need not be points of the input; all points where it has no more.
///
/// # Shapes
/// - `points`: n_points x 3, finite; `first` is the index of the point that is drawn first
/// - `tensors`: of [`shapes`] for some share of the widths
///
/// # Panics
/// When tensors are missing or of other shapes, or `first` does not exist.
///
/// ```
/// use neural_mesh::learned_baselines::{LearnedBaseline, LearnedWeights, potamias::simplified_points};
/// let sphere = neural_mesh::mesh::shapes::icosphere(3);
/// let weights = LearnedWeights::shipped(LearnedBaseline::Potamias);
/// assert_eq!(simplified_points(sphere.positions(), 100, 0, weights.tensors()).len(), 100);
/// ```
pub fn simplified_points(points: &[[f32; 3]], n: usize, first: u32, tensors: &Tensors<Arc<Matrix>>) -> Vec<[f32; 3]> {
    let Some(cloud) = Cloud::new(points) else { return points[..n.min(points.len())].to_vec() };
    let net = Potamias::of(&tensors.constants()).expect("the tensors of this network");
    let tape = &mut Tape::default();
    let latent = projection(tape, &net, &cloud);
    let samples = selection(&cloud, latent.matrix(), n, first);
    let refinement = refinement(tape, &net, &cloud, &latent, &samples);
    cloud.placed(&refinement.points())
}

/// Simplifies the vertices of a mesh and meshes them by balls, with the normals of the nearest vertices.
pub(super) fn simplified(
    mesh: &TriMesh,
    n_vertices: usize,
    seed: u64,
    tensors: &Tensors<Arc<Matrix>>,
) -> Result<TriMesh, LearnedBaselineError> {
    let (mesh, _) = compact(mesh.positions(), mesh.faces().to_vec())?;
    let vertices = mesh.positions();
    if vertices.is_empty() {
        return Err(LearnedBaselineError::NothingLeft);
    }
    let first = (seed % vertices.len() as u64) as u32;
    let points = simplified_points(vertices, n_vertices, first, tensors);
    let all = vertex_normals(&mesh);
    let normals: Vec<[f32; 3]> = nearest_to(vertices, &points, 1).iter().map(|&v| all[v as usize]).collect();
    Ok(compact(&points, ball_pivoting(&points, &normals))?.0)
}
