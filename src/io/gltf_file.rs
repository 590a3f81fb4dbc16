//! Mesh read from another format and written as a glTF file.

use super::OutputFile;

pub(super) struct GltfFile {
    pub bytes: Vec<u8>,
    pub images: Vec<OutputFile>,
    pub n_vertices: usize,
    pub notes: Vec<String>,
}
