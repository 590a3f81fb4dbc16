//! Input and options of a bake, and the reasons why it fails.

use crate::mesh::{Attributes, Looks, TriMesh};

/// Permitted texels per side.
pub const SIZES: std::ops::RangeInclusive<usize> = 16..=8192;

/// Mesh to be baked, with its materials.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct BakeSource<'a> {
    /// Surface.
    pub mesh: &'a TriMesh,
    /// Attributes of corners and faces.
    pub attributes: &'a Attributes,
    /// Materials of the groups.
    pub looks: &'a Looks,
}

/// Options for baking.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct BakeOptions {
    /// Texels per side of each texture, within [`SIZES`].
    pub size: usize,
    /// True if roughness and metal get separate images, as in MTL, instead of one, as in glTF.
    pub separate_maps: bool,
    /// True if corners get tangents.
    pub with_tangents: bool,
}

impl<'a> BakeSource<'a> {
    /// Makes an original from a mesh, its attributes and the materials of its groups.
    pub fn new(mesh: &'a TriMesh, attributes: &'a Attributes, looks: &'a Looks) -> Self {
        Self { mesh, attributes, looks }
    }
}

impl BakeOptions {
    /// Makes options for glTF: roughness and metal in one image, with tangents.
    pub fn new(size: usize) -> Self {
        Self { size, separate_maps: false, with_tangents: true }
    }
}

/// Reason for a failed bake.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum BakeError {
    /// Charts that do not fit on a texture of this size.
    NoRoom(usize),
    /// Size outside [`SIZES`].
    BadSize(usize),
    /// Mesh without faces.
    Empty,
}

impl std::fmt::Display for BakeError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (least, most) = (SIZES.start(), SIZES.end());
        match self {
            Self::NoRoom(size) => {
                write!(f, "the charts do not fit on {size} x {size} texels: choose more texels or fewer faces")
            }
            Self::BadSize(size) => write!(f, "{size} texels a side: give a whole number from {least} to {most}"),
            Self::Empty => write!(f, "no face has an area to bake onto: keep more faces"),
        }
    }
}

impl std::error::Error for BakeError {}
