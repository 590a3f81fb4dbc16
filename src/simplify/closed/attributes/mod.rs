//! What the corners of the result carry.

pub mod blend;
pub mod corners;
mod normals;
mod values;
