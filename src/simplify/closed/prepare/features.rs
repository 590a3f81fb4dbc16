//! What has to stay beside the shape: edges that stay edges (seams, creases), vertices that stay where they are.
//!
//! The kept edges are curves on the surface. The quotient keeps a curve where no region holds two pieces of it, or a whole
//! loop, and no two regions share two of its edges: then every region that a curve runs through is one point of it, and the
//! faces on either side stay on their side. Regions that break this are cut, like those that are no discs.

use rustc_hash::FxHashSet;

use crate::simplify::closed::cluster::darts::Assignment;
use crate::simplify::closed::pins::OnPlane;
use crate::simplify::closed::prepare::surface::Surface;

/// What a result has to keep, over the vertices of the surface.
#[derive(Default)]
pub struct Features {
    /// Edges that stay edges, the smaller vertex first, each once.
    pub edges: Vec<[u32; 2]>,
    /// Whether each vertex stays where it is; empty where all may go.
    pub locked: Vec<bool>,
    /// Whether the vertices of the result are vertices of the input.
    pub subset: bool,
    /// What stays on the plane, where the surface is one half of a mirrored one.
    pub on_plane: Option<OnPlane>,
    /// The vertices of the edges, ascending.
    vertices: Vec<u32>,
}

impl Features {
    /// Takes edges and locks over to the vertices of the surface, where some are copies.
    pub fn on(surface: &Surface, edges: &[[u32; 2]], locked: &[bool], subset: bool) -> Self {
        let is_locked = |v: u32| locked[v as usize];
        let locked = if locked.is_empty() { Vec::new() } else { surface.sources().map(is_locked).collect() };
        let has_copies = surface.n_split() > 0 && !edges.is_empty();
        let edges = if has_copies { on_copies(surface, edges) } else { edges.to_vec() };
        let mut vertices = edges.as_flattened().to_vec();
        vertices.sort_unstable();
        vertices.dedup();
        Self { edges, locked, subset, on_plane: None, vertices }
    }

    /// Whether there is nothing to keep.
    pub fn is_empty(&self) -> bool {
        self.edges.is_empty() && self.locked.is_empty() && !self.subset && self.on_plane.is_none()
    }

    /// Gives each locked vertex a region of its own; whether there was one.
    pub fn set_apart(&self, assignment: &mut Assignment) -> bool {
        let n_before = assignment.n_regions;
        let mut taken = vec![false; n_before];
        for v in (0..self.locked.len()).filter(|&v| self.locked[v]) {
            let region = &mut assignment.region[v];
            *region = assignment.n_regions as u32;
            assignment.n_regions += 1;
        }
        if assignment.n_regions == n_before {
            return false;
        }
        // Regions that hold nothing any more go.
        assignment.region.iter().filter(|&&r| (r as usize) < n_before).for_each(|&r| taken[r as usize] = true);
        let mut number = 0;
        let numbers: Vec<u32> = (0..assignment.n_regions)
            .map(|r| {
                let is_one = taken.get(r).copied().unwrap_or(true);
                number += u32::from(is_one);
                number.wrapping_sub(1)
            })
            .collect();
        assignment.region.iter_mut().for_each(|r| *r = numbers[*r as usize]);
        assignment.n_regions = number as usize;
        true
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
