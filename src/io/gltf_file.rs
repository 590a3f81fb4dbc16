//! A mesh of another format as a glTF file; plain data, also for builds without glTF.

use super::OutputFile;

/// A mesh as a glTF file.
pub(super) struct GltfFile {
    /// Content of the file.
    pub bytes: Vec<u8>,
    /// Image files.
    pub images: Vec<OutputFile>,
    /// Vertices in the file.
    pub n_vertices: usize,
    /// Losses, a line each.
    pub notes: Vec<String>,
}
