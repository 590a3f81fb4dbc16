//! The glTF file of a mesh of another format: plain data, also for builds without glTF.

use super::OutputFile;

/// A mesh as a file of glTF.
pub(super) struct BareFile {
    /// The file.
    pub bytes: Vec<u8>,
    /// Images beside it.
    pub beside: Vec<OutputFile>,
    /// Vertices that it has.
    pub n_vertices: usize,
    /// What glTF cannot hold of the mesh, in one line each.
    pub notes: Vec<String>,
}
