//! Options for writing a mesh with its attributes.

use super::{Format, ImageConverter, Packing};

/// Options for [`write_attributed`](super::write_attributed).
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct WriteOptions<'a> {
    /// Format of the file.
    pub format: Format,
    /// Name of the file without extension, also for a new material library.
    pub name: String,
    /// Whether files outside the asset's folder may be read; they are copied next to the output.
    pub allow_outside: bool,
    /// Packing of the numbers of a glTF, from [`packing`](super::packing).
    pub packing: Option<Packing>,
    /// Converter of the mesh's images, if any.
    pub images: Option<&'a dyn ImageConverter>,
    /// Whether a `.gltf` gets its images as files (`NAME_0.png`), so that several meshes share them.
    pub shares_images: bool,
}

impl WriteOptions<'_> {
    /// Makes options from a format and a file name without extension; files outside the asset's folder are not read.
    pub fn new(format: Format, name: impl Into<String>) -> Self {
        Self { format, name: name.into(), allow_outside: false, packing: None, images: None, shares_images: false }
    }
}
