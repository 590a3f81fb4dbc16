//! Collapse of one half of a mirrored mesh; sizes are those of the whole.

use crate::simplify::closed::pins::PlaneVertices;
use crate::simplify::limits::Limit;

use super::end_ring::EndRing;
use super::state::{Collapse, CollapseEnd};

impl Collapse<'_> {
    pub(super) fn plane(&self) -> Option<&PlaneVertices> {
        self.constraints.as_ref().and_then(|constraints| constraints.pins.plane())
    }

    /// Returns whether a merge would make the half and its image non-manifold.
    pub(super) fn would_break_whole(&self, [u, v]: [u32; 2], end_rings: &[EndRing; 2]) -> bool {
        let Some(plane) = self.plane() else { return false };
        let ids = |star: &EndRing| star.ring.iter().map(|&w| self.nodes[w as usize].id).collect::<Vec<u32>>();
        let [of_u, of_v] = [ids(&end_rings[0]), ids(&end_rings[1])];
        let rings = [&of_u[..], &of_v[..]];
        plane.would_bridge([u, v], rings)
            || plane.would_put_face_on_plane([u, v], rings)
            || plane.would_end_cut([u, v], rings)
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
