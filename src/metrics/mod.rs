//! How far a simplified mesh is from its original; the judge, which knows no method.

mod chamfer;
#[cfg(feature = "spectrum")]
mod comparison;
mod curvature_error;
mod open_edges;
mod self_intersections;
mod surface;
mod surface_distance;
mod turned_faces;

pub use chamfer::{Chamfer, chamfer};
#[cfg(feature = "spectrum")]
pub use comparison::{Figure, Judging, Original, compare};
pub use curvature_error::curvature_error;
pub use open_edges::{OpenEdges, open_edges};
pub use self_intersections::self_intersecting_faces;
pub use surface::Surface;
pub use surface_distance::{OneSided, SurfaceDistance, surface_distance};
pub use turned_faces::turned_faces;
