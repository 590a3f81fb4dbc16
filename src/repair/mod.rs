//! From a messy mesh to one that encloses a volume: holes filled, faces wound outward, what is inside or encloses nothing gone.
//!
//! ```text
//! fill_holes   loops of the boundary, each covered by triangles between its own vertices
//! printable    components that are too small, faces along which a surface turns out to have one side, fins
//!              holes, as above
//!              cells: which sides of faces see each other around edges (Attene 2018, "As-exact-as-possible repair of
//!              unprintable STL files"); of each body the faces between its solid and the rest stay, wound outward
//!              nesting: what lies inside solid is a cavity or goes
//! ```
//!
//! Faces come, go and turn; vertices stay where they are, but for those where bodies touch, which become several, a hair apart.
//! Surfaces that cross each other still do.

mod apart;
mod bodies;
mod cells;
mod components;
mod cover;
mod faces;
mod fill;
mod fins;
mod loops;
mod nesting;
mod one_sided;
mod rays;
mod repeated;
mod solid;

use crate::mesh::{Attributes, TriMesh};

pub use fill::{fill_holes, fill_some_holes};
pub use solid::printable;

/// What a repair did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct RepairCounts {
    /// Loops of the boundary that were closed.
    pub holes_filled: usize,
    /// Loops that were left: longer than asked for, or the border of a single face.
    pub holes_left: usize,
    /// Faces over the holes that are in the result.
    pub faces_added: usize,
    /// Faces of the input that are not in the result.
    pub faces_removed: usize,
    /// Faces of the input that are wound the other way in the result.
    pub faces_turned: usize,
    /// Components, joined over edges, of which nothing is left.
    pub components_dropped: usize,
    /// Components that came apart from others.
    pub components_added: usize,
    /// Components that were turned over as a whole.
    pub components_flipped: usize,
}

/// A mesh after a repair.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Repaired {
    /// The mesh; each of its vertices is one of the input.
    pub mesh: TriMesh,
    /// What its corners and faces carry.
    pub attributes: Attributes,
    /// The vertex of the input that each vertex is, n_vertices.
    pub sources: Vec<u32>,
    /// What was done.
    pub counts: RepairCounts,
}

/// Nothing of a mesh encloses a volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NothingSolid;

impl std::fmt::Display for NothingSolid {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "no component encloses a volume: give its sheets a thickness, or simplify it without this repair")
    }
}

impl std::error::Error for NothingSolid {}
