//! Measurements of a simplified mesh against its original.

mod certified_distance;
mod chamfer;
mod comparison;
mod curvature_error;
mod flip;
mod image_similarity;
mod measured_original;
mod open_edges;
mod painted_mesh;
mod quick_distance;
mod search_budget;
mod self_intersections;
mod streamed_distance;
mod surface;
mod surface_distance;
mod triangle_quality;
mod turned_faces;
mod volume;

pub use certified_distance::{CertifiedDistance, DistanceTolerance, certified_distance, largest_distance};
pub use chamfer::{Chamfer, chamfer};
pub use comparison::{CompareOptions, Figure, ReferenceMesh, compare};
pub use curvature_error::curvature_error;
pub use flip::flip;
pub use image_similarity::{psnr, silhouette_iou, ssim};
pub use measured_original::MeasuredOriginal;
pub use open_edges::{OpenEdges, open_edges};
pub use painted_mesh::{ColourScale, PaintedMesh, closest_point_tree, colour_scale};
pub use quick_distance::{QuickDistance, farthest_point, quick_distance};
use self_intersections::n_self_intersecting_faces;
pub use self_intersections::self_intersecting_faces;
pub use streamed_distance::{BlockDistances, StreamedDistance};
pub use surface::Surface;
pub use surface_distance::{OneSidedDistance, SurfaceDistance, surface_distance};
pub use triangle_quality::{TriangleQuality, triangle_quality};
use turned_faces::n_turned_faces;
pub use turned_faces::turned_faces;
pub use volume::volume;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::test_values::run_on_threads;
    use crate::mesh::{TriMesh, shapes};

    /// Makes large faces across a sphere, and the same a little aside.
    pub fn faces_across(sphere: &TriMesh, n_faces: u32, [a, b, c, d]: [u32; 4]) -> [TriMesh; 2] {
        let n = sphere.positions().len() as u32;
        let faces = (0..n_faces).map(|i| [i, (i * a + b) % n, (i * c + d) % n]);
        let faces: Vec<[u32; 3]> = faces.filter(|&[a, b, c]| a != b && b != c && c != a).collect();
        [0.0, 0.01].map(|aside| {
            let positions = sphere.positions().iter().map(|p| [p[0] + aside, p[1], p[2]]).collect();
            TriMesh::new(positions, faces.clone()).unwrap()
        })
    }

    #[test]
    fn nothing_has_no_figure() {
        let (nothing, sphere) = (TriMesh::default(), shapes::icosphere(0));
        let surfaces = [&nothing, &sphere].map(|mesh| Surface::new(mesh, 4000, 0));
        let point = [glam::DVec3::ZERO];
        assert!(chamfer(&[], &point).is_none() && chamfer(&point, &[]).is_none());
        assert!(curvature_error(&[], &[[0.0; 3]]).is_none() && curvature_error(&[[0.0; 3]], &[]).is_none());
        for [a, b] in [[0, 1], [1, 0]] {
            let meshes = [&nothing, &sphere];
            assert!(quick_distance(meshes[a], meshes[b], 10, 0).is_none());
            assert!(surface_distance(&surfaces[a], &surfaces[b]).is_none());
        }
        assert!(quick_distance(&sphere, &sphere, 0, 0).is_none());
        assert!(StreamedDistance::new(&nothing, [10, 1], 0).is_none());
        assert!(StreamedDistance::new(&sphere, [0, 1], 0).is_none());
        assert!(triangle_quality(&nothing).is_none());
        let edges = open_edges(&sphere, &nothing);
        assert_eq!((edges, edges.wa_percent()), (OpenEdges::default(), 0.0));
    }

    #[test]
    fn threads_do_not_change_a_bit() {
        let (a, b) = (shapes::bolt(32), shapes::bolt(9));
        let options = CompareOptions { samples: 3000, seed: 0 };
        let figures = || {
            let [original, simplified] = [&a, &b].map(|mesh| Surface::new(mesh, 4000, 0));
            let distances = (surface_distance(&original, &simplified), quick_distance(&a, &b, 4000, 0));
            (distances, compare(&ReferenceMesh::new(&a, &options), &b))
        };
        assert_eq!(run_on_threads(1, figures), run_on_threads(3, figures));
    }
}
