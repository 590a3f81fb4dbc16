//! Packed glTF: vertex values in small integers, and compressed buffers.

#[cfg(feature = "meshopt")]
mod compress;
#[cfg(not(feature = "meshopt"))]
#[path = "no_compress.rs"]
mod compress;
mod compressed_views;
mod packed_values;
mod shared_grids;
mod undo_position_grids;
mod uv_grids;

pub(super) use compress::order_faces;
pub(super) use packed_values::{PrimitivePacking, push_directions};
pub(super) use undo_position_grids::undo_position_grids;
pub(super) use uv_grids::{TRANSFORM, UvGrids, UvTransform, coordinates, for_each_texture_use};

use super::draft::Draft;
use super::repack::{PackedBuffer, pack};
use crate::io::{Packing, WriteError};

pub(super) const QUANTIZATION: &str = "KHR_mesh_quantization";

/// Packs all views into the buffer, compressed if the packing says so.
///
/// # Errors
/// [`WriteError`] if a view has no bytes, the buffer exceeds `limit`, or this build cannot compress.
pub(super) fn pack_as(
    draft: &mut Draft,
    buffer: &mut PackedBuffer,
    limit: usize,
    packing: Option<&Packing>,
) -> Result<(), WriteError> {
    match packing {
        Some(packing) if packing.is_compressed() && !compress::CAN_COMPRESS => {
            Err(WriteError::new("this build does not compress glTF: build with `--features meshopt`"))
        }
        Some(packing) if packing.is_compressed() => compressed_views::pack_compressed(draft, buffer, limit),
        _ => pack(draft, buffer, limit),
    }
}
