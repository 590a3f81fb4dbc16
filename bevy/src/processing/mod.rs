//! Simplification while assets are processed.

#[cfg(feature = "gltf")]
mod gltf;
#[cfg(feature = "gltf")]
mod gltf_source;
mod mesh_simplifier;
mod settings;

#[cfg(feature = "gltf")]
pub use gltf::{GltfSettings, GltfSimplifier, GltfSimplifierPlugin};
pub use mesh_simplifier::MeshSimplifier;
pub use settings::SimplifySettings;
