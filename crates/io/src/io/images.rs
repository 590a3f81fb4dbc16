//! Conversion of images while a mesh is written.

use std::fmt::Debug;

/// Meaning of an image's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ImageUse {
    /// sRGB colours, perhaps with opacity.
    Colours,
    /// Linear values: roughness, metal, occlusion, height, opacity alone.
    Numbers,
    /// Directions of a normal map.
    Normals,
}

/// Converter of images, for example to smaller ones.
pub trait ImageConverter: Debug + Sync {
    /// Returns the converted bytes of an image file, or `None` to keep the image.
    fn convert(&self, image: &[u8], used: ImageUse) -> Option<Vec<u8>>;

    /// Returns a word that distinguishes the names of converted images, where the original files stay.
    fn suffix(&self) -> Option<String> {
        None
    }
}
