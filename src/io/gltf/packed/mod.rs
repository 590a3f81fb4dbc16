//! glTF with small numbers (`KHR_mesh_quantization`): positions on a grid, directions and colours in bytes, texture coordinates on a
//! grid that their materials undo (`KHR_texture_transform`); and compressed (`EXT_meshopt_compression`).

#[cfg(feature = "meshopt")]
mod compress;
#[cfg(not(feature = "meshopt"))]
#[path = "no_compress.rs"]
mod compress;
mod parts;
mod placed_back;
mod uv_grids;
mod values;
mod views;

pub(super) use compress::ordered;
pub(super) use placed_back::place_back;
pub(super) use uv_grids::{TRANSFORM, UvGrids, UvTransform, coordinates, each_use};
pub(super) use values::{PackedAs, push_directions};

use super::draft::Draft;
use super::repack::pack;
use crate::io::{Packing, WriteError};

/// The extension by which attributes may have such numbers.
pub(super) const QUANTIZATION: &str = "KHR_mesh_quantization";

/// The one buffer of a document, compressed where the packing says so.
///
/// # Errors
/// [`WriteError`] where a view has no bytes, all of them are too many, or this build does not compress.
pub(super) fn pack_as(draft: &mut Draft, limit: usize, packing: Option<&Packing>) -> Result<Vec<u8>, WriteError> {
    match packing {
        Some(packing) if packing.is_compressed() && !compress::IS_HERE => {
            Err(WriteError { what: "this build does not compress glTF: build with `--features meshopt`".into() })
        }
        Some(packing) if packing.is_compressed() => views::pack_compressed(draft, limit),
        _ => pack(draft, limit),
    }
}
