//! What the Laplacian knows of a surface: its eigenpairs, and distances along it.

mod biharmonic;
mod carried;
mod eigenpairs;
mod factor;
mod heat_method;
mod lanczos;
mod longest_way;
mod pieces;
mod slabs;
mod spectrum_error;

pub use carried::Carried;
pub use eigenpairs::Eigenpairs;
pub use heat_method::HeatMethod;
pub use spectrum_error::spectrum_error;
