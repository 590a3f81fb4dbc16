//! Intrinsic geometry of surfaces with sparse solvers: eigenpairs, geodesic distances, and the errors of simplified
//! meshes.

mod figures;
mod intrinsic_surface;
mod judge;
mod laplacian;
mod spectrum;

pub use judge::{IntrinsicOptions, Judge};
pub use laplacian::Laplacian;
pub use spectrum::{Eigenpairs, HeatMethod};
