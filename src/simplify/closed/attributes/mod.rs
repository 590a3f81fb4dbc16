//! Attributes of the result's corners and faces.

pub mod blend;
pub mod corners;
pub mod kept;
mod normals;
mod values;
