//! A mesh of another format as a glTF file; plain data, also for builds without glTF.

use super::OutputFile;

pub(super) struct GltfFile {
    pub bytes: Vec<u8>,
    pub images: Vec<OutputFile>,
    pub n_vertices: usize,
    pub notes: Vec<String>,
}
