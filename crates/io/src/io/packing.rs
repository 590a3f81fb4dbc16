//! Packing of glTF numbers.

use crate::mesh::PositionGrid;

pub(super) type LevelMesh<'a> = (&'a [[f32; 3]], &'a [[u32; 3]]);

/// Options for packing the numbers of a glTF.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PackOptions {
    /// Bits per coordinate, at most [`MOST_BITS`](Self::MOST_BITS); more are used if fewer would merge vertices or
    /// flatten faces.
    pub bits: u32,
    /// True if buffers are compressed (`EXT_meshopt_compression`, feature `meshopt`).
    pub compress: bool,
}

impl PackOptions {
    /// Largest number of bits per coordinate.
    pub const MOST_BITS: u32 = 16;
}

/// Grids and compression for the numbers of a glTF.
#[derive(Clone, Debug, PartialEq)]
pub struct Packing {
    // `None` keeps positions in single precision.
    pub(super) grids: Vec<Option<PositionGrid>>,
    pub(super) compress: bool,
}

impl Packing {
    pub(super) fn for_levels(levels: &[LevelMesh], options: &PackOptions) -> (Self, Option<String>) {
        let grid = grid_for(levels, options.bits);
        let note = grid.is_none().then(|| format!("positions {}", unpacked_words()));
        (Self { grids: vec![grid], compress: options.compress }, note)
    }

    /// Returns the position grid of a part, or `None` for single precision.
    pub fn grid(&self, part: usize) -> Option<&PositionGrid> {
        self.grids.get(part)?.as_ref()
    }

    /// Returns whether buffers are compressed.
    pub fn is_compressed(&self) -> bool {
        self.compress
    }
}

/// Returns the coarsest grid of at least `bits` bits that keeps all vertices distinct and all faces' areas.
pub(super) fn grid_for(meshes: &[LevelMesh], bits: u32) -> Option<PositionGrid> {
    let corners =
        || meshes.iter().flat_map(|(positions, faces)| faces.as_flattened().iter().map(|&v| positions[v as usize]));
    // Grids are tried from coarse to fine: the first that keeps all meshes gives the smallest file.
    let grids = (bits..=PackOptions::MOST_BITS).filter_map(|bits| PositionGrid::from_points(corners(), bits));
    let mut grids = grids.filter(|grid| meshes.iter().all(|(positions, faces)| grid.preserves(positions, faces)));
    grids.next()
}

pub(super) fn unpacked_words() -> String {
    let most = PackOptions::MOST_BITS;
    format!(
        "are not quantised: a grid of {most} bits would merge vertices or flatten faces, or other data needs exact positions"
    )
}
