//! Results and their files.

use crate::io::{OutputFile, Packing};
use crate::simplify::Simplified;

use super::baked_material::BakedMaterial;

/// Results for one file.
#[derive(Default)]
pub struct Meshes<'a> {
    /// One result, or the levels of detail of a scene.
    pub results: Vec<&'a Simplified>,
    /// Share of the screen's area down to which each level is drawn.
    pub coverage: Vec<f64>,
    /// Baked material.
    pub baked: Option<&'a BakedMaterial>,
    /// Packing of a glTF.
    pub packing: Option<&'a Packing>,
}

/// Files of a result.
#[derive(Default)]
pub struct Files {
    /// Mesh file.
    pub bytes: Vec<u8>,
    /// Companion files, such as textures.
    pub companion_files: Vec<OutputFile>,
    /// Content that the format cannot store, one line each.
    pub notes: Vec<String>,
    /// Vertices of each result in the file.
    pub n_vertices: Vec<Option<usize>>,
}

impl Files {
    /// Returns the bytes of the mesh file and of its glTF buffers.
    pub fn n_bytes(&self) -> usize {
        let buffers =
            self.companion_files.iter().filter(|file| file.path.extension().is_some_and(|ending| ending == "bin"));
        self.bytes.len() + buffers.map(|file| file.bytes.len()).sum::<usize>()
    }
}
