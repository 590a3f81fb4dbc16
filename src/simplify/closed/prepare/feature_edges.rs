//! Edges that stay edges: seams and creases.
//!
//! They are curves on the surface. The quotient keeps a curve where no region holds two pieces of it, or a whole loop, and no
//! two regions share two of its edges: then every region that a curve runs through is one point of it, and the faces on either
//! side stay on their side. Regions that break this are cut, like those that are no discs.

use rustc_hash::FxHashSet;

use crate::simplify::closed::cluster::assignment::Assignment;

use super::surface::Surface;

/// The edges that stay edges, over the vertices of the surface.
#[derive(Default)]
pub struct FeatureEdges {
    /// The edges, the smaller vertex first, each once.
    pub edges: Vec<[u32; 2]>,
    /// The vertices of the edges, ascending.
    vertices: Vec<u32>,
}

impl FeatureEdges {
    /// Takes edges over to the vertices of the surface, where some are copies.
    pub fn on(surface: &Surface, edges: &[[u32; 2]]) -> Self {
        let has_copies = surface.n_split() > 0 && !edges.is_empty();
        let edges = if has_copies { on_copies(surface, edges) } else { edges.to_vec() };
        let mut vertices = edges.as_flattened().to_vec();
        vertices.sort_unstable();
        vertices.dedup();
        Self { edges, vertices }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.edges.is_empty()
    }

    /// Marks the regions that hold two pieces of kept curves or a whole loop, or that share two of their edges.
    pub fn mark_broken(&self, assignment: &Assignment, broken: &mut [bool]) {
        if self.edges.is_empty() {
            return;
        }
        let region = |v: u32| assignment.region[v as usize];
        let (mut n_vertices, mut n_edges) = (vec![0u32; assignment.n_regions], vec![0u32; assignment.n_regions]);
        self.vertices.iter().for_each(|&v| n_vertices[region(v) as usize] += 1);
        let mut between = Vec::new();
        for [r, s] in self.edges.iter().map(|edge| edge.map(region)) {
            if r == s {
                n_edges[r as usize] += 1;
            } else {
                between.push([r.min(s), r.max(s)]);
            }
        }
        for (broken, (vertices, edges)) in broken.iter_mut().zip(n_vertices.into_iter().zip(n_edges)) {
            *broken |= vertices > 0 && vertices != edges + 1;
        }
        between.sort_unstable();
        let twice = between.windows(2).filter(|pair| pair[0] == pair[1]);
        twice.flat_map(|pair| pair[0]).for_each(|r| broken[r as usize] = true);
    }

    /// The edges between the vertices that `vertex_of` says the surface's became, each once.
    pub fn edges_between(&self, vertex_of: &[u32]) -> Vec<[u32; 2]> {
        let ends = |edge: &[u32; 2]| {
            let [a, b] = edge.map(|v| vertex_of[v as usize]);
            (a != b).then_some([a.min(b), a.max(b)])
        };
        let mut edges: Vec<[u32; 2]> = self.edges.iter().filter_map(ends).collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    }
}

/// The surface's edges over these edges of the mesh.
fn on_copies(surface: &Surface, edges: &[[u32; 2]]) -> Vec<[u32; 2]> {
    let wanted: FxHashSet<[u32; 2]> = edges.iter().copied().collect();
    let mut touched = vec![false; surface.n_vertices()];
    edges.as_flattened().iter().for_each(|&v| touched[v as usize] = true);
    let is_wanted = |&[a, b]: &[u32; 2]| {
        let [a, b] = [a, b].map(|v| surface.source(v));
        touched[a as usize] && touched[b as usize] && wanted.contains(&[a.min(b), a.max(b)])
    };
    let sides = surface.faces.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let mut found: Vec<[u32; 2]> = sides.filter(is_wanted).map(|[a, b]| [a.min(b), a.max(b)]).collect();
    found.sort_unstable();
    found.dedup();
    found
}
