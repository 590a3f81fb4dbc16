//! Errors of eigenpairs and distances along a surface.

mod figures;
mod intrinsic_surface;
mod judge;
mod laplacian;
mod spectrum;

pub use intrinsic_surface::IntrinsicOptions;
pub use judge::Judge;
pub use laplacian::Laplacian;
pub use spectrum::{Eigenpairs, HeatMethod};
