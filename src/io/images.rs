//! Conversion of the images that an asset refers to.

use std::fmt::Debug;

/// The meaning of an image's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ImageUse {
    /// sRGB colours, perhaps with opacity.
    Colours,
    /// Linear values: roughness, metal, occlusion, height, opacity alone.
    Numbers,
    /// Directions of a normal map.
    Normals,
}

/// A converter of images, for example to smaller ones.
pub trait ImageConverter: Debug + Sync {
    /// Returns the converted file in the same format, as names and media types stay, or `None` to keep the image.
    fn convert(&self, image: &[u8], used: ImageUse) -> Option<Vec<u8>>;
}
