//! The collapse of one half of a mirrored mesh: sizes are those of the whole, and what is on the plane stays there.
//!
//! A merge within the cut takes one vertex of the whole, any other two. So the whole comes to its size but for one vertex
//! first; where one is too many then, the cheapest merge within the cut takes it.

use crate::simplify::closed::pins::PlaneVertices;
use crate::simplify::limits::Limit;

use super::complex::{Collapse, End};
use super::star::Star;

impl Collapse<'_> {
    /// The vertices that stay on the plane, where this is the collapse of a half.
    pub(super) fn plane(&self) -> Option<&PlaneVertices> {
        self.constraints.as_ref().and_then(|constraints| constraints.pins.plane())
    }

    /// Whether after a merge of these vertices of the surface the surface and its image would be no manifold: they would share an edge
    /// beside the cut, or a face, or no edge but a vertex.
    pub(super) fn would_break_whole(&self, [u, v]: [u32; 2], stars: &[Star; 2]) -> bool {
        let Some(plane) = self.plane() else { return false };
        let ids = |star: &Star| star.ring.iter().map(|&w| self.nodes[w as usize].id).collect::<Vec<u32>>();
        let [of_u, of_v] = [ids(&stars[0]), ids(&stars[1])];
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
        self.begin_pass();
        let Some(plane) = self.plane() else { return };
        let is_on = |v: u32| plane.has(self.nodes[v as usize].id);
        let mut edges = Vec::new();
        for u in self.living().filter(|&u| is_on(u)) {
            let is_along = |edge: &(f32, u32)| self.corners.edge(edge.1).into_iter().all(is_on);
            edges.extend(self.edges_at(u).into_iter().filter(is_along).map(|(price, edge)| (price, edge, u)));
        }
        edges.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
        _ = edges.into_iter().any(|(_, edge, u)| self.try_merge(u, edge));
    }
}
