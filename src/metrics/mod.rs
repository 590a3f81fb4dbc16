//! How far a simplified mesh is from its original; the judge, which knows no method.

mod surface;
mod surface_distance;

pub use surface::Surface;
pub use surface_distance::{OneSided, SurfaceDistance, surface_distance};
