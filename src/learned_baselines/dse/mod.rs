//! Surfaces from points: "Learning Delaunay Surface Elements for Mesh Reconstruction" (Rakotosaona, Guerrero, Aigerman, Mitra,
//! Ovsjanikov, CVPR 2021).
//!
//! For every point of a cloud a network says which of the nearest points are geodesic neighbours, another lays these out in
//! the plane as the logarithmic map at the point does, maps of neighbours are aligned, and the triangles around a point in
//! the Delaunay triangulation of its map are candidates of a surface, chosen by how many of their corners have them.
//!
//! What the networks learn is an exact map on the mesh from which the points were drawn; with it the rest of the method runs,
//! too, which says what is lost to learning. What was decided where the text is not precise stands in each file.

mod alignment;
mod exact_map;
mod forward;
mod learned_patches;
mod losses;
mod neighbourhoods;
mod network;
mod overlap;
mod patch;
mod reconstruct;
mod selection;
mod sizes;
#[cfg(test)]
mod test_golden;
mod turn;
mod umbrella;
mod votes;

use super::LearnedBaselineError;
use crate::autodiff::Tensors;
use crate::linalg::Matrix;
use crate::mesh::{TriMesh, compact, vertex_normals};
use crate::spatial::farthest_points;
use glam::Vec3;
use std::sync::Arc;

pub use alignment::aligned;
pub use exact_map::{Surface, exact_patches, exact_patches_at};
pub use forward::forward;
pub use learned_patches::learned_patches;
pub use losses::{Loss, map_loss, neighbour_loss};
pub use neighbourhoods::{Frame, Neighbourhoods};
pub use network::{Dse, JoinedLayers, PointNetwork, drawn, shapes};
pub use overlap::lie_over_each_other;
pub use patch::Patch;
pub use reconstruct::reconstruct;
pub use selection::selected;
pub use sizes::{CANDIDATES, KEPT, Widths};
pub use turn::Turn;
pub use umbrella::umbrella;
pub use votes::votes;

/// Which maps a mesh is made with.
#[derive(Clone, Copy, Debug)]
pub enum Maps<'a> {
    /// Those of the networks of these tensors, which see points alone.
    Learned(&'a Tensors<Arc<Matrix>>),
    /// Exact ones, which see the mesh.
    Exact,
}

/// Draws farthest points of a mesh and meshes them, with learned or with exact maps.
///
/// The method says nothing of sides, so faces look to the side that the mesh's normals at their corners do.
///
/// # Errors
/// [`LearnedBaselineError`] where nothing is left.
///
/// ```
/// use neural_mesh::{learned_baselines::dse::{Maps, remeshed}, mesh::shapes};
/// let lighter = remeshed(&shapes::icosphere(3), 160, 0, Maps::Exact).unwrap();
/// assert!((310..=316).contains(&lighter.faces().len()));
/// ```
pub fn remeshed(mesh: &TriMesh, n_vertices: usize, seed: u64, maps: Maps<'_>) -> Result<TriMesh, LearnedBaselineError> {
    let (mesh, _) = compact(mesh.positions(), mesh.faces().to_vec())?;
    if mesh.positions().is_empty() {
        return Err(LearnedBaselineError::NothingLeft);
    }
    let first = (seed % mesh.positions().len() as u64) as u32;
    let mut samples = farthest_points(mesh.positions(), n_vertices, first);
    samples.sort_unstable();
    let points: Vec<[f32; 3]> = samples.iter().map(|&v| mesh.positions()[v as usize]).collect();
    let patches = match maps {
        Maps::Learned(tensors) => learned_patches(&points, tensors),
        Maps::Exact => exact_patches(&mesh, &samples, KEPT),
    };
    let all = vertex_normals(&mesh);
    let normals: Vec<Vec3> = samples.iter().map(|&v| all[v as usize].into()).collect();
    let faces = reconstruct(&points, &patches).into_iter().map(|face| turned_to(face, &points, &normals));
    Ok(compact(&points, faces.collect())?.0)
}

/// A face wound to the side of the normals at its corners.
fn turned_to([a, b, c]: [u32; 3], points: &[[f32; 3]], normals: &[Vec3]) -> [u32; 3] {
    let [p, q, r] = [a, b, c].map(|v| Vec3::from(points[v as usize]));
    let side: f32 = [a, b, c].iter().map(|&v| normals[v as usize].dot((q - p).cross(r - p))).sum();
    if side < 0.0 { [a, c, b] } else { [a, b, c] }
}
