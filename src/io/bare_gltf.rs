//! How a mesh that came from no glTF file is written as glTF, and what it becomes: plain data, also for builds without glTF.

use super::{Format, ImageMaker, OutputFile, Packing};

/// How a mesh that came from no glTF file is written.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(not(feature = "gltf"), allow(dead_code, reason = "builds without glTF write none"))]
pub(super) struct BareOptions<'a> {
    /// glTF or GLB.
    pub format: Format,
    /// How its numbers are packed.
    pub packing: Option<&'a Packing>,
    /// Who makes other images of those that it wears.
    pub images: Option<&'a dyn ImageMaker>,
    /// The name after which its images become files beside JSON.
    pub shared_images: Option<&'a str>,
}

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
