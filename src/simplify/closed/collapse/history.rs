//! What a collapse writes down, so that its result is known as a function of where it began.

use glam::Vec3;

use crate::simplify::closed::prepare::surface::folds_around;

use super::pair::Place;

/// A ghost vertex in the ring of a [`Renewal`].
pub const GHOST: u32 = u32::MAX;

/// What changed, in order.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// Two vertices became one.
    Merge(Merge),
    /// The quadric of a vertex was summed anew.
    Renewal(Renewal),
}

/// A merge of two vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Merge {
    /// The vertex that stays.
    pub kept: u32,
    /// The one merged into it.
    pub gone: u32,
    /// Where the merged vertex went.
    pub place: Place,
}

/// A quadric summed anew over the faces around a vertex.
#[derive(Clone, Debug, PartialEq)]
pub struct Renewal {
    /// The vertex.
    pub vertex: u32,
    /// Its neighbours in order; [`GHOST`] for a ghost vertex.
    pub ring: Vec<u32>,
    /// Those of them to which a fold runs.
    pub folds: Vec<u32>,
    /// How much more than its area it counts.
    pub importance: f32,
    /// How much more it is drawn to where it is for its weight.
    pub bend: f32,
}

impl Renewal {
    /// Of a vertex at `position` with these neighbours in order, [`GHOST`] for a ghost vertex, and where each of them lies; how much it
    /// counts, and bends.
    pub fn new(
        vertex: u32,
        ring: Vec<u32>,
        position: Vec3,
        place: impl Fn(usize) -> Option<Vec3>,
        [importance, bend]: [f32; 2],
    ) -> Self {
        let folds = folds_around(position, (0..ring.len()).map(place)).map(|i| ring[i]).collect();
        Self { vertex, ring, folds, importance, bend }
    }
}
