//! Surfaces as seen from within, which takes sparse factors: eigenpairs of the Laplacian, distances along the surface, and what a
//! simplified mesh leaves of both.

mod figures;
mod intrinsic;
mod judge;
mod laplacian;
mod spectrum;

pub use judge::{AlongJudging, Judge};
pub use laplacian::Laplacian;
pub use spectrum::{Eigenpairs, HeatMethod};
