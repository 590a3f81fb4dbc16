//! Collapse of one half of a mirrored mesh; sizes are those of the whole.

use crate::simplify::closed::pins::PlaneVertices;
use crate::simplify::limits::Limit;

use super::end_ring::EndRing;
use super::merge::Merger;
use super::state::{Collapse, CollapseEnd};

impl Collapse<'_> {
    pub(super) fn plane(&self) -> Option<&PlaneVertices> {
        self.rules.constraints.as_ref().and_then(|constraints| constraints.pins.plane())
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
        let on_plane: Vec<bool> = self.nodes[..self.n_inner].iter().map(|node| plane.contains(node.id)).collect();
        let ends: Vec<u32> = self.remaining().filter(|&u| on_plane[u as usize]).collect();
        self.merge_with(|merger| {
            let is_on = |v: u32| on_plane.get(v as usize).is_some_and(|is_on| *is_on);
            let mut edges = Vec::new();
            for u in ends {
                let of_u = merger.edges_at(u).unwrap_or_default().into_iter();
                let is_along = |edge: &(f32, u32)| merger.stretch.corners.edge(edge.1).into_iter().all(is_on);
                edges.extend(of_u.filter(is_along).map(|(price, edge)| (price, edge, u)));
            }
            // The cheapest edge that passes all tests is taken.
            edges.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
            _ = edges.into_iter().any(|(_, edge, u)| merger.try_merge(u, edge).unwrap_or(false));
        });
    }
}

impl Merger<'_> {
    /// Returns whether a merge of surface vertices would make the half and its image non-manifold.
    pub(super) fn would_break_whole(&self, plane: &PlaneVertices, ends: [u32; 2], end_rings: &[EndRing; 2]) -> bool {
        let ids = |star: &EndRing| star.ring.iter().map(|&w| self.stretch.node(w).id).collect::<Vec<u32>>();
        let [of_u, of_v] = [ids(&end_rings[0]), ids(&end_rings[1])];
        let rings = [&of_u[..], &of_v[..]];
        plane.would_bridge(ends, rings)
            || plane.would_put_face_on_plane(ends, rings)
            || plane.would_end_cut(ends, rings)
    }
}
