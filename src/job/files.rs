//! Results and their files.

use crate::io::{Format, OutputFile, Packing};
use crate::simplify::Simplified;

use super::baked_material::BakedMaterial;

/// Simplified meshes that go into one file.
#[derive(Default)]
pub struct Meshes<'a> {
    /// One result, or the levels of detail of a scene.
    pub results: Vec<&'a Simplified>,
    /// Share of the screen's area down to which each level is drawn; empty if unknown.
    pub coverage: Vec<f64>,
    /// Distance from which each level is drawn, rising from 0; empty if unknown.
    pub distances: Vec<f64>,
    /// Baked material.
    pub baked: Option<&'a BakedMaterial>,
    /// Packing of a glTF.
    pub packing: Option<&'a Packing>,
}

/// One mesh file and its companion files.
#[derive(Clone, Default)]
pub struct Files {
    /// Content of the mesh file.
    pub bytes: Vec<u8>,
    /// Companion files, such as textures.
    pub companion_files: Vec<OutputFile>,
    /// Content that the format cannot store, one line each.
    pub notes: Vec<String>,
    /// Number of each result's vertices in the file; `None` for STL.
    pub n_vertices: Vec<Option<usize>>,
}

impl Files {
    /// Returns the bytes of the mesh file; of a glTF together with its buffers and images.
    pub fn n_bytes(&self, format: Format) -> usize {
        let others = self.companion_files.iter().filter(|_| matches!(format, Format::Gltf | Format::Glb));
        self.bytes.len() + others.map(|file| file.bytes.len()).sum::<usize>()
    }
}
