//! Measurements of a simplified mesh against its original.

mod certified_distance;
mod chamfer;
mod comparison;
mod curvature_error;
mod flip;
mod image_similarity;
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

#[doc(hidden)]
pub use certified_distance::certified_distance_with_budget;
pub use certified_distance::{CertifiedDistance, DistanceTolerance, certified_distance, largest_distance};
pub use chamfer::{Chamfer, chamfer};
pub use comparison::{CompareOptions, Figure, ReferenceMesh, compare};
pub use curvature_error::curvature_error;
pub use flip::flip;
pub use image_similarity::{psnr, silhouette_iou, ssim};
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
