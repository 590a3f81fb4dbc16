//! Triangles over points: "PointTriNet: Learned Triangulation of 3D Point Sets" (Sharp and Ovsjanikov, ECCV 2020).
//!
//! One network classifies triangles, another proposes the next ones.

mod candidates;
mod classifier;
mod local_frame;
mod network;
mod overlap_kernel;
mod patches;
mod proposal_match;
mod proposals;
mod rounds;
mod step;
mod surface_to_triangles;
#[cfg(test)]
mod test_golden;
mod triangle_samples;
mod triangles_to_surface;
mod watertightness;

use super::{compact_with_first_point, farthest_vertices};
use crate::baselines::points_and_normals;
use anyhow::Result;
use glam::Vec3;
use neural_mesh::autodiff::Tensors;
use neural_mesh::geometry::triangle::area_normal;
use neural_mesh::linalg::Matrix;
use neural_mesh::mesh::{TriMesh, compact};
use std::sync::Arc;

pub use network::shapes;
pub use step::pointtrinet_step;

use candidates::Candidates;
use classifier::classifier;
use local_frame::LocalFrame;
use overlap_kernel::overlap_kernel;
use patches::CandidateNeighbourhoods;
use proposal_match::proposal_match;
use proposals::{Draw, Proposal, point_probabilities, proposals};
use rounds::{last_candidates, triangulate};
use surface_to_triangles::surface_to_triangles;
use triangle_samples::{TriangleSample, triangle_samples};
use triangles_to_surface::{SurfacePoint, triangles_to_surface};
use watertightness::watertightness;

pub(super) fn simplify(
    mesh: &TriMesh,
    n_vertices: usize,
    seed: u64,
    tensors: &Tensors<Arc<Matrix>>,
) -> Result<TriMesh> {
    let (mesh, first) = compact_with_first_point(mesh, seed)?;
    let [points, normals] = points_and_normals(&mesh, &farthest_vertices(&mesh, n_vertices, first));
    let faces = triangulate(&tensors.constants(), &points, seed);
    let faces = faces.into_iter().map(|face| orient_face(face, &points, &normals)).collect();
    Ok(compact(&points, faces)?.0)
}

fn orient_face(face: [u32; 3], points: &[[f32; 3]], normals: &[[f32; 3]]) -> [u32; 3] {
    let [a, b, c] = face;
    let normal = area_normal(face.map(|v| Vec3::from_array(points[v as usize])));
    let mean: Vec3 = face.iter().map(|&v| Vec3::from_array(normals[v as usize])).sum();
    if normal.dot(mean) < 0.0 { [a, c, b] } else { face }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_look_to_the_side_of_the_normals() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        assert_eq!(orient_face([0, 1, 2], &points, &[[0.0, 0.0, 1.0]; 3]), [0, 1, 2]);
        assert_eq!(orient_face([0, 1, 2], &points, &[[0.0, 0.0, -1.0]; 3]), [0, 2, 1]);
    }
}
