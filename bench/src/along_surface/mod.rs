//! Errors of eigenpairs and distances along a surface.

mod figures;
mod judge;
mod laplacian;
mod spectrum;

pub use judge::{EIGENPAIRS, Judge};
pub use laplacian::Laplacian;
pub use spectrum::{Eigenpairs, HeatMethod};
