//! A mesh in blocks, each simplified for itself: for meshes that do not fit into memory, or that many workers share.
//!
//! A block is the faces of a box, about [`FACES`] of them. Vertices that several blocks use stay
//! where they are, and one price holds for all blocks: each is simplified as long as merges cost no more, to about
//! [`TIMES`] times the size asked for altogether. What is left is joined and simplified as any other mesh, across the borders, to the
//! size asked for. Blocks depend on the mesh alone, so results do not depend on memory, workers or threads.
//!
//! Where a mesh is closed and manifold, so are its joined blocks: borders keep their vertices and edges, and an edge that two blocks
//! have made between vertices of a border is parted in one of them.

mod block;
#[cfg(feature = "io")]
mod described;
mod join;
#[cfg(feature = "io")]
mod out_of_core;
mod plan;
mod price;
#[cfg(feature = "io")]
mod spooled;

pub use block::{Block, cut, simplify_block};
#[cfg(feature = "io")]
pub use described::{Described, describe_pieces};
pub use join::join;
#[cfg(feature = "io")]
pub use out_of_core::{Heard, OutOfCore, OutOfCoreError, Room, simplify_pieces};
pub use price::{Sample, price_for, sample_block};

/// Faces of a block, about.
pub const FACES: usize = 1 << 19;
/// Vertices that the blocks leave altogether, over those asked for.
pub const TIMES: f64 = 2.0;
