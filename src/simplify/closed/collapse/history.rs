//! What a collapse writes down, so that its result is known as a function of where it began.

use glam::Vec3;

use crate::mesh::OneRings;
use crate::simplify::closed::cluster::placement::Placement;
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
    /// Of a vertex with these neighbours in order, [`GHOST`] for a ghost vertex, where they lie now; how much it counts, and bends.
    pub fn new(vertex: u32, ring: Vec<u32>, place: impl Fn(u32) -> Vec3, [importance, bend]: [f32; 2]) -> Self {
        let places = ring.iter().map(|&w| (w != GHOST).then(|| place(w)));
        let folds = folds_around(place(vertex), places).map(|i| ring[i]).collect();
        Self { vertex, ring, folds, importance, bend }
    }
}

/// What a history begins with: the quadrics of regions that are no vertices, over the faces of the quotient, which has these rings.
pub fn first_quadrics(placed: &Placement, rings: &OneRings) -> Vec<Event> {
    if placed.is_of_surface() {
        return Vec::new();
    }
    let n_regions = rings.n_vertices() as u32;
    let place = |region: u32| placed.position(region).as_vec3();
    let first = |vertex: u32| {
        let ring = rings.ring(vertex).iter().map(|&w| if w < n_regions { w } else { GHOST }).collect();
        Event::Renewal(Renewal::new(vertex, ring, place, [placed.importance(vertex), 0.0]))
    };
    (0..n_regions).map(first).collect()
}
