//! How the numbers of a glTF are packed: each grid of positions is as fine as its meshes need to be the same on it.

use crate::mesh::Grid;

/// Positions in single precision and faces over them.
pub(super) type Faces<'a> = (&'a [[f32; 3]], &'a [[u32; 3]]);

/// What is asked of a packing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PackOptions {
    /// Bits of each coordinate of a position, up to [`MOST_BITS`](Self::MOST_BITS); more where the mesh would be another one.
    pub bits: u32,
    /// Whether buffers are compressed, too (`EXT_meshopt_compression`, feature `meshopt`).
    pub compress: bool,
}

impl PackOptions {
    /// Bits of a coordinate at most.
    pub const MOST_BITS: u32 = 16;
}

/// How the numbers of a glTF are packed.
#[derive(Clone, Debug, PartialEq)]
pub struct Packing {
    /// The grid of each part; none where its positions stay in single precision.
    pub(super) grids: Vec<Option<Grid>>,
    /// Whether buffers are compressed.
    pub(super) compress: bool,
}

impl Packing {
    /// Meshes over positions in single precision, all of them levels of one, on one grid. The note says where there is none.
    pub(super) fn of_levels(levels: &[Faces], options: &PackOptions) -> (Self, Option<String>) {
        let grid = grid_for(levels, options.bits);
        let note = grid.is_none().then(|| format!("positions {}", stays()));
        (Self { grids: vec![grid], compress: options.compress }, note)
    }

    /// The grid on which the positions of a part lie.
    pub fn grid(&self, part: usize) -> Option<&Grid> {
        self.grids.get(part)?.as_ref()
    }

    /// Whether buffers are compressed.
    pub fn is_compressed(&self) -> bool {
        self.compress
    }
}

/// The coarsest grid, of so many bits or more, on which all these meshes are the same.
pub(super) fn grid_for(meshes: &[Faces], bits: u32) -> Option<Grid> {
    let corners =
        || meshes.iter().flat_map(|(positions, faces)| faces.as_flattened().iter().map(|&v| positions[v as usize]));
    let grids = (bits..=PackOptions::MOST_BITS).filter_map(|bits| Grid::around(corners(), bits));
    let mut grids = grids.filter(|grid| meshes.iter().all(|(positions, faces)| grid.holds(positions, faces)));
    grids.next()
}

/// What becomes of positions without a grid.
pub(super) fn stays() -> String {
    let most = PackOptions::MOST_BITS;
    format!(
        "stay in single precision: on a grid of {most} bits it would be another mesh, or something else counts on them"
    )
}
