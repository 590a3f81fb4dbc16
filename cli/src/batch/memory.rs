//! How much memory a mesh takes, by its file, and how much there is.

use std::borrow::Cow;

use neural_mesh::io::Format;

use super::inputs::Input;
use crate::memory::available;

/// What a run takes whatever the mesh.
const BASE: u64 = 8 << 20;
/// Bytes for each texel that is baked: the texels themselves, and an image and its file for two textures at once.
const TEXEL: u64 = 32;
/// Bound where the system does not say how much memory is free.
const FALLBACK: u64 = 4 << 30;

/// About the most bytes that a run on the mesh takes, from above. A face takes 250 bytes there, and in a file 20 in binary
/// PLY and glTF, twice as many in STL and in text.
pub fn estimate(input: &Input, bake: Option<usize>) -> u64 {
    let bytes = std::fs::metadata(&input.path).map_or(0, |found| found.len());
    let factor = match Format::from_path(&input.path) {
        Some(Format::Ply | Format::Gltf | Format::Glb) => 14,
        _ => 7,
    };
    // Compressed meshes become about five times as long, the text of 3MF ten times.
    let packing = match (Format::without_gz(&input.path), Format::from_path(&input.path)) {
        (_, Some(Format::ThreeMf)) => 10,
        (Cow::Owned(_), _) => 5,
        _ => 1,
    };
    let textures = bake.map_or(0, |size| TEXEL * (size as u64).pow(2));
    BASE + factor * packing * bytes + textures
}

/// Half of what is free.
pub fn default_bound() -> u64 {
    available().unwrap_or(FALLBACK) / 2
}
