//! Vertices with very many neighbours: they stay, and their neighbours are not listed.
//!
//! Each merge beside a vertex takes a pass over its neighbours, so that the merges around one take the square of their number. What
//! is asked of a vertex that stays is found in the lists of its neighbours: faces, and that an edge is shared.

use super::complex::Collapse;
use super::links::Span;

/// Neighbours of a vertex at most that are listed. Merges around it take a few microseconds each then, about what others take; no
/// mesh of the benchmark has a vertex with more than a hundredth of it.
const MOST: usize = 4096;

impl Collapse<'_> {
    /// Holds the vertices with too many neighbours, no two of them beside each other. Nothing is held in one half of a mirrored mesh,
    /// where lists say what meets the plane.
    pub(super) fn hold_hubs(&mut self) {
        if self.plane().is_some() {
            return;
        }
        for v in 0..self.n_inner {
            let ring = self.nodes[v].ring;
            if ring.len() <= MOST && !ring.is_unlisted() {
                continue;
            }
            let is_beside = |w: u32| self.nodes.get(w as usize).is_some_and(|_| !self.is_ghost(w) && self.is_hub(w));
            if ring.is_unlisted() || !self.links.of(ring).any(is_beside) {
                self.frozen.resize(self.n_inner, false);
                self.frozen[v] = true;
                self.nodes[v].ring = Span::unlisted(ring.len() as u32);
            }
        }
    }

    /// Whether a vertex that is no ghost has neighbours that are not listed.
    #[inline(always)]
    pub(super) fn is_hub(&self, v: u32) -> bool {
        self.nodes[v as usize].ring.is_unlisted()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::pulse::Pulse;
    use crate::mesh::{TriMesh, compact, topology};
    use crate::simplify::closed::cluster::assignment::Assignment;
    use crate::simplify::closed::cluster::placement::{Placement, Places};
    use crate::simplify::closed::collapse::End;
    use crate::simplify::closed::prepare::surface::Surface;
    use crate::simplify::limits::Limit;

    /// Faces around a vertex; closed by a second one below where `n_around` faces go all the way around.
    fn fan(n: u32, is_closed: bool) -> TriMesh {
        let turn = std::f32::consts::TAU * if is_closed { 1.0 } else { 0.9 };
        let rim = |i: u32| {
            let angle = turn * i as f32 / n as f32;
            [angle.cos(), angle.sin(), 0.1 * (7.0 * angle).sin()]
        };
        let n_rim = if is_closed { n } else { n + 1 };
        let positions = [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]].into_iter().chain((0..n_rim).map(rim));
        let next = |i: u32| 2 + (i + 1) % n_rim;
        let above = (0..n).map(|i| [0, 2 + i, next(i)]);
        let below = (0..n).filter(|_| is_closed).map(|i| [1, next(i), 2 + i]);
        let positions: Vec<[f32; 3]> = positions.collect();
        compact(&positions, above.chain(below).collect()).unwrap().0
    }

    #[test]
    fn the_middle_of_a_large_fan_is_held_and_the_rest_is_collapsed() {
        // The second is large enough for blocks.
        for (n, is_closed) in [(5000, false), (5000, true), (70_000, false)] {
            let mesh = fan(n, is_closed);
            let surface = Surface::new(&mesh, Pulse::NONE);
            let placed = Placement::new(&surface, Places::default(), &[]);
            let limit = Limit::of_vertices(surface.n_vertices() / 10);
            let mut collapse = Collapse::toward(Pulse::NONE, limit, 1.1, &placed, &surface.rings, Vec::new());
            assert_eq!(collapse.run(limit, 1.1), End::Reached);
            assert!(collapse.living().filter(|&v| collapse.is_hub(v)).count() == if is_closed { 2 } else { 1 });
            let output = collapse.output(&Assignment::identity(surface.n_vertices()));
            assert_eq!((output.positions.len(), output.faces().len()), (limit.vertices, collapse.n_faces));
            let faces = output.faces().to_vec();
            let lighter = TriMesh::new(output.positions.iter().map(|p| p.to_array()).collect(), faces).unwrap();
            let (before, after) = (topology(&mesh), topology(&lighter));
            assert_eq!(after.non_manifold_edges + after.non_manifold_vertices + after.unreferenced_vertices, 0);
            assert_eq!((after.euler, after.components), (before.euler, before.components));
            assert_eq!((after.boundary_loops, after.inconsistent_edges), (before.boundary_loops, 0));
        }
    }
}
