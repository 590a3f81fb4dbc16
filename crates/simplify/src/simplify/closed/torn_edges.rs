//! Edges of more than two faces that the manifold cut open: while they are few their vertices stay, so that no gap opens.

use crate::simplify::limits::Limit;

use super::original::Original;
use super::prepare::surface::PreparedSurface;
use super::request::ClosedRequest;

/// Most of a result's vertices that stay at cut edges, as one of so many.
const LEAST_FREE: usize = 4;

/// Pins the vertices of edges along which the surface was cut open, unless they are too many for the last of `limits`.
pub fn hold_torn_edges(original: &mut Original, request: &ClosedRequest, limits: &[Limit]) {
    // Mirrored halves and derivatives count on the numbers of the collapse.
    let has_own_numbers = request.differentiable || original.pins.plane().is_some();
    let Some(last) = limits.last().filter(|_| !has_own_numbers) else { return };
    let surface = &original.surface;
    let is_torn = torn_vertices(surface);
    let n_torn = is_torn.iter().filter(|is_torn| **is_torn).count();
    if n_torn == 0 || LEAST_FREE * n_torn > last.size() {
        return;
    }
    let held: Vec<bool> = surface.sources().map(|source| is_torn[source as usize]).collect();
    let n_copies = held.iter().filter(|is_held| **is_held).count() - n_torn;
    original.pins.hold(&held, n_copies);
}

/// Marks the mesh's vertices at edges of several faces of which a sheet has only one; empty if no vertex was split.
fn torn_vertices(surface: &PreparedSurface) -> Vec<bool> {
    if surface.n_split() == 0 {
        return Vec::new();
    }
    let n_own = surface.n_vertices() - surface.n_split();
    let mut is_split = vec![false; n_own];
    surface.sources().skip(n_own).for_each(|source| is_split[source as usize] = true);
    // Each side of a face with both ends at split vertices: the ends' sources, then the ends themselves.
    let side = |a: u32, b: u32| {
        let [s, t] = [a, b].map(|v| surface.source(v));
        let is_near = is_split[s as usize] && is_split[t as usize];
        is_near.then(|| [s.min(t), s.max(t), a.min(b), a.max(b)])
    };
    let sides = surface.faces.iter().flat_map(|&[a, b, c]| [side(a, b), side(b, c), side(c, a)]);
    let mut sides: Vec<[u32; 4]> = sides.flatten().collect();
    sides.sort_unstable();
    let mut is_torn = vec![false; n_own];
    for edge in sides.chunk_by(|x, y| x[..2] == y[..2]).filter(|edge| edge.len() > 1) {
        let has_rim = edge.chunk_by(|x, y| x == y).any(|sheet| sheet.len() == 1);
        edge[0][..2].iter().for_each(|&source| is_torn[source as usize] |= has_rim);
    }
    is_torn
}
