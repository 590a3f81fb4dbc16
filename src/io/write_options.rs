//! How a mesh is written with all that it carries.

use super::{Format, ImageMaker, Packing};

/// How a model is written.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct WriteOptions<'a> {
    /// The format.
    pub format: Format,
    /// What the file is called, without its extension: a library of materials that has to be made is named after it.
    pub name: String,
    /// Whether files that the asset names may be read from outside its folder; they are copied beside the output.
    pub allow_outside: bool,
    /// How the numbers of a glTF are packed, as [`packing`](super::packing) says for the model.
    pub packing: Option<Packing>,
    /// Who makes other images of those that the mesh wears, where someone does.
    pub images: Option<&'a dyn ImageMaker>,
    /// Whether images within a `.gltf` become files beside it, `NAME_0.png`, for several meshes to share them.
    pub shares_images: bool,
}

impl WriteOptions<'_> {
    /// A format, and the file's name without its extension; what the asset names is read from its own folder alone.
    pub fn new(format: Format, name: impl Into<String>) -> Self {
        Self { format, name: name.into(), allow_outside: false, packing: None, images: None, shares_images: false }
    }
}
