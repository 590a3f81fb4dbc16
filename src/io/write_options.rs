//! Options for writing a mesh with its attributes.

use super::{Format, ImageMaker, Packing};

/// Options for writing a model.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct WriteOptions<'a> {
    /// The format.
    pub format: Format,
    /// The name of the file without its extension; a new library of materials takes it, too.
    pub name: String,
    /// Whether files outside the folder of the asset may be read; they are copied beside the output.
    pub allow_outside: bool,
    /// The packing of the numbers in a glTF, as [`packing`](super::packing) returns it for the model.
    pub packing: Option<Packing>,
    /// Who makes other images of those that the mesh wears, where someone does.
    pub images: Option<&'a dyn ImageMaker>,
    /// Whether images in a `.gltf` become files beside it, `NAME_0.png`, so that several meshes share them.
    pub shares_images: bool,
}

impl WriteOptions<'_> {
    /// A format, and the file's name without its extension; what the asset names is read from its own folder alone.
    pub fn new(format: Format, name: impl Into<String>) -> Self {
        Self { format, name: name.into(), allow_outside: false, packing: None, images: None, shares_images: false }
    }
}
