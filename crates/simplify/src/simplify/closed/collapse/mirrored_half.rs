//! Collapse of one half of a mirrored mesh; sizes are those of the whole.

use crate::simplify::closed::pins::PlaneVertices;
use crate::simplify::limits::Limit;

use super::end_ring::EndRing;
use super::state::{Collapse, CollapseEnd};

impl Collapse<'_> {
    pub(super) fn plane(&self) -> Option<&PlaneVertices> {
        self.constraints.as_ref().and_then(|constraints| constraints.pins.plane())
    }

    /// Returns whether a merge that passes the link condition would make the half and its image non-manifold.
    pub(super) fn would_break_whole(&self, ends: [u32; 2], end_rings: &[EndRing; 2]) -> bool {
        let Some(plane) = self.plane() else { return false };
        let is_on = |&v: &u32| plane.contains(self.nodes[v as usize].id);
        // Each ring begins with the other end.
        let [of_u, of_v] = end_rings.each_ref().map(|star| &star.ring[1..]);
        let gained = match ends.map(|v| is_on(&v)) {
            [false, false] => return false,
            // The cut must continue at one of the ends.
            [true, true] => return !of_u.iter().chain(of_v).any(is_on),
            [true, false] => of_v,
            [false, true] => of_u,
        };
        // The end on the plane gains neighbours between the two that it shares. An edge to another plane vertex would
        // be a bridge; with no vertex between, the shared ones form a face, which must not be in the plane.
        match gained {
            [first, between @ .., last] => {
                between.iter().any(is_on) || between.is_empty() && is_on(first) && is_on(last)
            }
            _ => false,
        }
    }

    pub(super) fn run_half(&mut self, limit: Limit) -> CollapseEnd {
        // A merge along the cut removes one vertex of the whole mesh, any other merge two. So the collapse stops one
        // vertex early, and merges along the cut if one vertex is still too many.
        let nearly =
            Limit { vertices: limit.vertices.saturating_add(1), faces: limit.faces.saturating_add(2), ..limit };
        let end = self.run_to(nearly);
        if end == CollapseEnd::Reached && !self.has_reached(limit) {
            self.merge_within_cut();
        }
        if end == CollapseEnd::Reached { self.run_to(limit) } else { end }
    }

    fn merge_within_cut(&mut self) {
        self.begin_pass();
        let Some(plane) = self.plane() else { return };
        let is_on = |v: u32| plane.contains(self.nodes[v as usize].id);
        let mut edges = Vec::new();
        for u in self.remaining().filter(|&u| is_on(u)) {
            let is_along = |edge: &(f32, u32)| self.corners.edge(edge.1).into_iter().all(is_on);
            edges.extend(self.edges_at(u).into_iter().filter(is_along).map(|(price, edge)| (price, edge, u)));
        }
        // The cheapest edge that passes all tests is taken.
        edges.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
        _ = edges.into_iter().any(|(_, edge, u)| self.try_merge(u, edge));
    }
}
