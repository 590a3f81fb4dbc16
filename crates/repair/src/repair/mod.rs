//! Fills holes, and makes a messy mesh enclose a volume.
//!
//! ```text
//! fill_holes   boundary loops, each covered by triangles between its own vertices
//! printable    drops small components, faces that make a surface one-sided, and fins
//!              fills holes, as above
//!              cells: which sides of faces see each other around edges (Attene 2018, "As-exact-as-possible repair of
//!              unprintable STL files"); keeps the faces between each body's solid and the rest, wound outward
//!              nesting: a body within solid is a cavity or dropped
//! ```
//!
//! Vertices stay in place, except that touching bodies are separated slightly. Intersecting surfaces still intersect.

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
mod touching;

use crate::mesh::{Attributes, TriMesh};

pub use fill::{fill_holes, fill_some_holes};
pub use solid::printable;

/// Numbers of changes made by a repair.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct RepairCounts {
    /// Boundary loops that were closed.
    pub holes_filled: usize,
    /// Boundary loops left open.
    pub holes_left: usize,
    /// New faces over holes.
    pub faces_added: usize,
    /// Input faces that were dropped.
    pub faces_removed: usize,
    /// Input faces that were reversed.
    pub faces_turned: usize,
    /// Components that were dropped.
    pub components_dropped: usize,
    /// Components split off others.
    pub components_added: usize,
    /// Components that were reversed as a whole.
    pub components_flipped: usize,
}

/// A repaired mesh.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Repaired {
    /// The mesh; its vertices are input vertices.
    pub mesh: TriMesh,
    /// Attributes of the mesh.
    pub attributes: Attributes,
    /// Input vertex of each vertex, n_vertices.
    pub sources: Vec<u32>,
    /// Numbers of changes.
    pub counts: RepairCounts,
}

/// The error of a mesh without a solid body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NothingSolid;

impl std::fmt::Display for NothingSolid {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "no component encloses a volume: give its sheets a thickness, or simplify it without this repair")
    }
}

impl std::error::Error for NothingSolid {}
