//! Simplification in blocks, for meshes larger than memory or shared by several workers.
//!
//! A block has the faces in a box, about [`FACES_PER_BLOCK`]; vertices shared by blocks stay. One price holds for all
//! blocks, at which they keep about [`VERTEX_SURPLUS`] times the requested size. The joined blocks are then simplified
//! to that size. Results do not depend on memory, workers or threads. A closed manifold stays one.

mod block;
#[cfg(feature = "io")]
mod file_description;
mod join;
#[cfg(feature = "io")]
mod out_of_core;
mod plan;
mod price;
#[cfg(feature = "io")]
mod spooled_blocks;

pub use block::{Block, cut, simplify_block};
#[cfg(feature = "io")]
pub use file_description::{FileDescription, describe_pieces};
pub use join::join;
#[cfg(feature = "io")]
pub use out_of_core::{OutOfCoreError, OutOfCoreResult, ProgressCallback, WorkingSpace, simplify_pieces};
#[cfg(all(feature = "io", feature = "job"))]
pub(crate) use out_of_core::{check_room, cut_file, report_progress};
pub use price::{BlockPrices, price_for, sample_block};
#[cfg(all(feature = "io", feature = "job"))]
pub(crate) use spooled_blocks::StoredBlock;

/// Approximate number of faces per block.
pub const FACES_PER_BLOCK: usize = 1 << 19;
/// Vertices kept by all blocks together, as a multiple of the requested number.
pub const VERTEX_SURPLUS: f64 = 2.0;
