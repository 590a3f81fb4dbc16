//! History of a collapse, for its derivative.

use glam::Vec3;

use crate::simplify::closed::prepare::surface::folds_around;

use super::pair::Placement;

pub const GHOST: u32 = u32::MAX;

#[derive(Clone, Debug, PartialEq)]
pub enum CollapseEvent {
    Merge(Merge),
    Renewal(Renewal),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Merge {
    pub kept: u32,
    pub removed: u32,
    pub place: Placement,
}

/// Quadric recomputed over the faces around a vertex.
#[derive(Clone, Debug, PartialEq)]
pub struct Renewal {
    pub vertex: u32,
    pub ring: Vec<u32>,
    pub folds: Vec<u32>,
    pub importance: f32,
    /// Factor of the pull that grows with the squared weight.
    pub growing_pull: f32,
}

impl Renewal {
    /// Records a vertex; `place` returns neighbours' positions, `None` for ghost vertices.
    pub fn new(
        vertex: u32,
        ring: Vec<u32>,
        position: Vec3,
        place: impl Fn(usize) -> Option<Vec3>,
        [importance, growing_pull]: [f32; 2],
    ) -> Self {
        let folds = folds_around(position, (0..ring.len()).map(place)).map(|i| ring[i]).collect();
        Self { vertex, ring, folds, importance, growing_pull }
    }
}
