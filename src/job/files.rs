//! Results and their files.

use crate::io::{OutputFile, Packing};
use crate::simplify::Simplified;

use super::dress::Dress;

/// The results for one file.
#[derive(Default)]
pub struct Meshes<'a> {
    /// One result, or the levels of detail of a scene.
    pub results: Vec<&'a Simplified>,
    /// Share of the screen down to which each level is drawn.
    pub coverage: Vec<f64>,
    /// Baked material in place of the original's.
    pub dress: Option<&'a Dress>,
    /// Packing of a glTF.
    pub packing: Option<&'a Packing>,
}

/// The files of a result.
#[derive(Default)]
pub struct Files {
    /// Mesh file.
    pub bytes: Vec<u8>,
    /// Companion files, such as textures.
    pub beside: Vec<OutputFile>,
    /// Remarks about content that the format cannot store, one line each.
    pub notes: Vec<String>,
    /// Vertices of each result in the file, if it has any.
    pub n_vertices: Vec<Option<usize>>,
}

impl Files {
    /// Returns the bytes of the mesh, with those of the buffers of a JSON glTF.
    pub fn n_bytes(&self) -> usize {
        let buffers = self.beside.iter().filter(|file| file.path.extension().is_some_and(|ending| ending == "bin"));
        self.bytes.len() + buffers.map(|file| file.bytes.len()).sum::<usize>()
    }
}
