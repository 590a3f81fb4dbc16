//! Results as files.

use crate::io::{OutputFile, Packing};
use crate::simplify::Simplified;

use super::dress::Dress;

/// Results that are to be written.
#[derive(Default)]
pub struct Meshes<'a> {
    /// One, or the levels of detail of a scene.
    pub results: Vec<&'a Simplified>,
    /// Shares of the screen down to which these are meant to be drawn.
    pub coverage: Vec<f64>,
    /// What the result wears in place of what it has of the original.
    pub dress: Option<&'a Dress>,
    /// How the numbers of a glTF are packed, where they are.
    pub packing: Option<&'a Packing>,
}

/// A result as files.
#[derive(Default)]
pub struct Files {
    /// The mesh.
    pub bytes: Vec<u8>,
    /// What belongs beside it.
    pub beside: Vec<OutputFile>,
    /// What the format does not hold, in one line each.
    pub notes: Vec<String>,
    /// Vertices of each result as the file has them, where it has such.
    pub n_vertices: Vec<Option<usize>>,
}

impl Files {
    /// Bytes of the mesh, with those of the buffer that a JSON has beside it.
    pub fn n_bytes(&self) -> usize {
        let buffers = self.beside.iter().filter(|file| file.path.extension().is_some_and(|ending| ending == "bin"));
        self.bytes.len() + buffers.map(|file| file.bytes.len()).sum::<usize>()
    }
}
