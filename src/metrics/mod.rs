//! How far a simplified mesh is from its original; the judge, which knows no method.

mod allowance;
mod certified_distance;
mod chamfer;
mod comparison;
mod curvature_error;
mod distance_in_pieces;
mod image_likeness;
mod open_edges;
mod painted_distance;
mod quick_distance;
mod self_intersections;
mod surface;
mod surface_distance;
mod triangle_quality;
mod turned_faces;
mod volume;

pub(crate) use certified_distance::certified_within;
pub use certified_distance::{CertifiedDistance, Sharpness, certified_distance, largest_distance};
pub use chamfer::{Chamfer, chamfer};
pub use comparison::{Figure, Judging, Original, compare};
pub use curvature_error::curvature_error;
pub use distance_in_pieces::{DistanceInPieces, Look};
pub use image_likeness::{psnr, silhouette_iou, ssim};
pub use open_edges::{OpenEdges, open_edges};
pub use painted_distance::{Painted, PaintedScale, nearest_on, painted_scale};
pub use quick_distance::{QuickDistance, farthest_point, quick_distance};
use self_intersections::n_self_intersecting_faces;
pub use self_intersections::self_intersecting_faces;
pub use surface::Surface;
pub use surface_distance::{OneSided, SurfaceDistance, surface_distance};
pub use triangle_quality::{TriangleQuality, triangle_quality};
use turned_faces::n_turned_faces;
pub use turned_faces::turned_faces;
pub use volume::volume;
