//! Options that are one of several names.

use serde::{Deserialize, Serialize};

/// Kind of attribute that is discarded, so that its seams and borders do not limit the result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
pub enum Ignored {
    /// Texture coordinates and tangents.
    Uv,
    /// Normals; shading then follows the faces.
    Normals,
    /// Vertex colours.
    #[cfg_attr(feature = "clap", value(alias = "colours"))]
    Colors,
    /// Materials and groups of faces.
    Materials,
}

impl Ignored {
    /// Returns the name of the option's value.
    pub fn name(self) -> &'static str {
        match self {
            Self::Uv => "uv",
            Self::Normals => "normals",
            Self::Colors => "colors",
            Self::Materials => "materials",
        }
    }
}

/// Compression of a glTF.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
pub enum Compression {
    /// Quantise and compress with meshopt.
    Meshopt,
    /// Quantise only.
    Quantize,
}

/// Unit of the levels of detail.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
pub enum LodsBy {
    /// Vertices.
    Vertices,
    /// Faces.
    Faces,
    /// Largest distances to the original.
    Error,
}

/// Engine whose convention levels of detail follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
pub enum Engine {
    /// One file, with nodes `NAME_LOD0`, `NAME_LOD1` under a node `NAME`.
    Unity,
    /// One file per level, `NAME_LOD0`, `NAME_LOD1`.
    Unreal,
    /// As for Unity.
    Godot,
    /// One glTF with `MSFT_lod`.
    Gltf,
}

/// Name of an assembly, the method that builds the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
pub enum AssemblyName {
    /// Collapses edges; a closed mesh stays closed.
    #[default]
    Closed,
    /// The method of the paper: the most probable faces of the network; leaves holes.
    Paper,
}
