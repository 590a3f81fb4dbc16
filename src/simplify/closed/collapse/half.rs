//! The collapse of one half of a mirrored mesh: sizes are those of the whole, and what is on the plane stays there.
//!
//! A merge within the cut takes one vertex of the whole, any other two. So the whole comes to its size but for one vertex
//! first; where one is too many then, the cheapest merge within the cut takes it.

use crate::simplify::closed::pins::PlaneVertices;
use crate::simplify::limits::Limit;

use super::complex::{Collapse, End};

impl Collapse<'_> {
    /// The vertices that stay on the plane, where this is the collapse of a half.
    pub(super) fn plane(&self) -> Option<&PlaneVertices> {
        self.constraints.as_ref().and_then(|constraints| constraints.pins.plane())
    }

    /// Whether after a merge the surface and its image would be no manifold: they would share an edge beside the cut, or a face, or
    /// no edge but a vertex.
    pub(super) fn would_break_whole(&self, u: u32, v: u32) -> bool {
        let Some(plane) = self.plane() else { return false };
        let [of_u, of_v] = [u, v].map(|w| self.ring(w).collect::<Vec<u32>>());
        let rings = [&of_u[..], &of_v[..]];
        plane.would_bridge([u, v], rings) || plane.would_lay_flat([u, v], rings) || plane.would_end_cut([u, v], rings)
    }

    /// Collapses until the whole is at the limit, exactly where that can be.
    pub(super) fn run_half(&mut self, limit: Limit) -> End {
        let nearly =
            Limit { vertices: limit.vertices.saturating_add(1), faces: limit.faces.saturating_add(2), ..limit };
        let end = self.run_to(nearly);
        if end == End::Reached && !self.reached(limit) {
            self.merge_within_cut();
        }
        if end == End::Reached { self.run_to(limit) } else { end }
    }

    /// Does the cheapest merge of two neighbours on the cut that may be done, if there is one.
    fn merge_within_cut(&mut self) {
        let Some(plane) = self.plane() else { return };
        let mut edges = Vec::new();
        for u in self.living().filter(|&u| plane.has(u)) {
            let along = self.ring(u).filter(|&v| v > u && plane.has(v));
            edges.extend(
                along.map(|v| (self.constrained_price(u, v), [u, v])).filter(|(price, _)| *price < f32::INFINITY),
            );
        }
        edges.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
        _ = edges.into_iter().any(|(_, [u, v])| self.try_merge(u, v));
    }
}
