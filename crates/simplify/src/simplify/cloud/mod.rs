//! Geometry of point clouds: noise, tangent planes, triangles around points, and faces that form a manifold.

mod closing;
mod manifold_faces;
mod pinches;
mod planes;
mod smoothing;
mod stars;

pub use closing::close_surface;
pub use manifold_faces::ManifoldFaces;
pub use smoothing::smooth_noise;
pub use stars::{StarTriangles, star_triangles};
