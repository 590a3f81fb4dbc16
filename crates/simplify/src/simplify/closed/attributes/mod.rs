//! Attributes of the result's corners and faces.

pub mod blend;
pub mod kept_faces;
mod normals;
pub mod result_corners;
mod values;
