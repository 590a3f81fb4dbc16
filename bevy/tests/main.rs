//! Tests of the crate, on whole meshes and a whole asset processor.

mod attributes;
mod errors;
mod helpers;
mod levels;
#[cfg(feature = "gltf")]
mod processing;
mod topology;
mod transformer;
