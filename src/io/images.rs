//! What becomes of the images that an asset refers to, on their way into files.

use std::fmt::Debug;

/// What the numbers of an image mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ImageUse {
    /// Colours as sRGB has them, perhaps with opacity.
    Colours,
    /// Numbers: roughness, metal, occlusion, height, opacity alone.
    Numbers,
    /// Directions, with 0 in the middle of the range.
    Normals,
}

/// Makes other images of those that an asset refers to, such as smaller ones.
pub trait ImageMaker: Debug + Sync {
    /// The bytes of the file that takes the place of this one, in the same format, since names and media types stay; none
    /// where the image stays as it is.
    fn made(&self, image: &[u8], used: ImageUse) -> Option<Vec<u8>>;
}
