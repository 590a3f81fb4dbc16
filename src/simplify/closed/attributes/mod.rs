//! What the corners of the result carry.

pub mod blend;
pub mod corners;
pub mod kept;
mod normals;
mod values;
