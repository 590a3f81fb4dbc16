//! History of a collapse, for its derivative.

use glam::Vec3;

use crate::simplify::closed::prepare::surface::folds_around;

use super::pair::Placement;
use neural_mesh_collapse::PassMerge;

pub const GHOST: u32 = u32::MAX;

#[derive(Clone, Debug, PartialEq)]
pub enum CollapseEvent {
    Merge(Merge),
    Renewal(Renewal),
    /// The merges of a pass of the kernel, in their order.
    Pass(Vec<PassMerge>),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Merge {
    pub kept: u32,
    pub removed: u32,
    pub place: Placement,
}

/// Record that a vertex's quadric was recomputed over its present faces.
#[derive(Clone, Debug, PartialEq)]
pub struct Renewal {
    pub vertex: u32,
    pub ring: Vec<u32>,
    pub folds: Vec<u32>,
    pub importance: f32,
    /// Factor of the pull that grows with the squared trace of the planes.
    pub growing_pull: f32,
}

impl Renewal {
    /// Records a vertex's new quadric; `place(i)` is the position of neighbour `ring[i]`, `None` for a ghost vertex.
    pub fn new(
        vertex: u32,
        ring: Vec<u32>,
        position: Vec3,
        place: impl Fn(usize) -> Option<Vec3>,
        [importance, growing_pull]: [f32; 2],
    ) -> Self {
        let folds = folds_around(position, ring.len(), place).map(|i| ring[i]).collect();
        Self { vertex, ring, folds, importance, growing_pull }
    }
}
