//! Spectral geometry: eigenpairs and distances of the Laplacian.

mod biharmonic;
mod components;
mod eigenpairs;
mod factor;
mod heat_method;
mod lanczos;
mod longest_path;
mod slabs;
mod spectrum_error;
mod symmetric;
mod value_transfer;

pub use eigenpairs::Eigenpairs;
pub use heat_method::HeatMethod;
pub use spectrum_error::spectrum_error;
pub use value_transfer::ValueTransfer;
