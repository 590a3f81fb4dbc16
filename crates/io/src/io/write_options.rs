//! Options for writing a mesh.

use super::{Format, ImageConverter, OutputFolder, Packing};

/// Options for [`write_attributed`](super::write_attributed).
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct WriteOptions<'a> {
    /// Format of the file.
    pub format: Format,
    /// Name of the file without extension.
    pub name: String,
    /// True if files outside the asset's folder may be read and copied.
    pub allow_outside: bool,
    /// Packing of a glTF, from [`packing`](super::packing).
    pub packing: Option<Packing>,
    /// Converter of images, such as a resizer.
    pub images: Option<&'a dyn ImageConverter>,
    /// True if the images of a `.gltf` are written as separate files (`NAME_0.png`).
    pub shares_images: bool,
    /// Folder of the results, if they are written to disk.
    pub folder: Option<OutputFolder>,
}

impl WriteOptions<'_> {
    /// Makes options; files outside the asset's folder are not read.
    pub fn new(format: Format, name: impl Into<String>) -> Self {
        let name = name.into();
        Self { format, name, allow_outside: false, packing: None, images: None, shares_images: false, folder: None }
    }
}
