//! Merges at a boundary, one face at a time: along a boundary edge, or of a vertex inside into one on the boundary.
//!
//! ```text
//!      b0 - b1                   b0 - b1
//!     /  \ / \                  /  \ / \        u stays; the border is open, from one boundary edge to the other
//!  --u----v---bn--    ---->  --x--------bn--    v on the boundary, too: a merge along the edge removes one face
//! ```

use crate::collapse::lanes::{VertexQuadric, dispatch};
use crate::collapse::merge::{EdgeToMerge, LEAST_COSINE_SQUARED};
use crate::collapse::placement::place_pair;
use crate::collapse::rings::state;
use crate::collapse::stretch::{PassView, Refusal, VertexStretch};
use crate::collapse::vector::{Point, cross, dot, squared_distance_to_segment, subtract};

/// Merges v into u on the boundary; returns the number of faces that go, the place and v, both seen from u.
/// An edge between two boundary vertices is a boundary edge.
#[inline(never)]
pub(crate) fn merge_at_boundary(
    pass: &PassView,
    stretch: &mut VertexStretch,
    edge: EdgeToMerge,
) -> Result<(usize, [Point; 2]), Refusal> {
    let (ring_u, ring_v) = (pass.rings.ring(edge.u), pass.rings.ring(edge.v));
    let (u, v) = (edge.u - stretch.first, edge.v - stretch.first);
    let is_along = stretch.states[v as usize] & state::BOUNDARY != 0;
    let at_v = ring_u.iter().position(|&w| w == edge.v).ok_or(Refusal::Topology)?;
    let border = trace_border(stretch, ring_u, ring_v, edge.u, at_v)?;
    // The vertices next to both: one, or two if v is inside.
    let mut sides = Vec::with_capacity(2);
    for at in [at_v.wrapping_sub(1), at_v + 1] {
        if let Some(&w) = ring_u.get(at) {
            sides.push(stretch.survivor(w).ok_or(Refusal::Outside)?);
        }
    }
    if sides.iter().any(|&w| stretch.has_least_degree(w)) {
        return Err(Refusal::Topology);
    }
    let [pu, pv] = [u, v].map(|w| stretch.vertices[w as usize].position);
    let d = subtract(pv, pu);
    let (qu, qv) = (&pass.terms.quadrics[edge.u as usize], &pass.terms.quadrics[edge.v as usize]);
    let seen = if edge.is_fixed { [0.0; 3] } else { place_pair(qu, qv, d, None) };
    let x = [pu[0] + seen[0], pu[1] + seen[1], pu[2] + seen[2]];
    check_turns(stretch, ring_u, pu, x, edge.v, false)?;
    check_turns(stretch, ring_v, pv, x, edge.u, !is_along)?;
    let error = measure_error(stretch, &border, [u, v], x, is_along) + edge.measure_loss(qu, qv);
    // Lines weigh squared lengths in place of areas: around slivers they allow more than the pass's limit.
    let lines = weigh_lines(qu) + weigh_lines(qv);
    let own_limit = (pass.price / lines.max(1e-37)).sqrt();
    if error > pass.guard.max(own_limit).min(pass.max_error) {
        return Err(Refusal::Guard);
    }
    stretch.write_merge(u, v, x, border.len(), error);
    for &w in &sides {
        stretch.degrees[w as usize] -= 1;
    }
    Ok((sides.len(), [seen, d]))
}

// The weight of the lines in a quadric, whose trace is twice that and the area's.
fn weigh_lines(q: &VertexQuadric) -> f32 {
    (0.5 * (q.0[0] + q.0[3] + q.0[5] - q.0[6])).max(0.0)
}

// The ring of the merged vertex: that of u with the rest of v's in place of v.
fn trace_border(
    stretch: &VertexStretch,
    ring_u: &[u32],
    ring_v: &[u32],
    u: u32,
    at_v: usize,
) -> Result<Vec<u32>, Refusal> {
    let at_u = ring_v.iter().position(|&w| w == u).ok_or(Refusal::Topology)?;
    let around_v = ring_v[at_u + 1..].iter().chain(&ring_v[..at_u]);
    let mut border: Vec<u32> = Vec::with_capacity(ring_u.len() + ring_v.len());
    for &w in ring_u[..at_v].iter().chain(around_v).chain(&ring_u[at_v + 1..]) {
        let w = stretch.survivor(w).ok_or(Refusal::Outside)?;
        if border.last() != Some(&w) {
            border.push(w);
        }
    }
    // A vertex met again is next to both ends, and is no side of the edge.
    let mut sorted = border.clone();
    sorted.sort_unstable();
    if border.len() < 2 || sorted.windows(2).any(|pair| pair[0] == pair[1]) {
        return Err(Refusal::Topology);
    }
    Ok(border)
}

// Refuses if a face around `tip` that stays turns when the tip moves to `x`.
fn check_turns(
    stretch: &VertexStretch,
    ring: &[u32],
    tip: Point,
    x: Point,
    other: u32,
    is_closed: bool,
) -> Result<(), Refusal> {
    let n_faces = if is_closed { ring.len() } else { ring.len() - 1 };
    for i in 0..n_faces {
        let (a, b) = (ring[i], ring[(i + 1) % ring.len()]);
        if a == other || b == other {
            continue;
        }
        let (Some(a), Some(b)) = (stretch.survivor(a), stretch.survivor(b)) else { return Err(Refusal::Outside) };
        if a == b {
            continue;
        }
        let [pa, pb] = [a, b].map(|w| stretch.vertices[w as usize].position);
        let edge = subtract(pb, pa);
        let (old, new) = (cross(edge, subtract(tip, pa)), cross(edge, subtract(x, pa)));
        let along = dot(old, new);
        if !(along > 0.0 && along * along > LEAST_COSINE_SQUARED * dot(old, old) * dot(new, new)) {
            return Err(Refusal::Turn);
        }
    }
    Ok(())
}

// The errors of both ends and how far they lie from the new boundary, or from the new faces if v is inside.
fn measure_error(stretch: &VertexStretch, border: &[u32], ends: [u32; 2], x: Point, is_along: bool) -> f32 {
    let position = |w: u32| stretch.vertices[w as usize].position;
    let error = |end: u32| {
        let d = subtract(position(end), x);
        let squared = if is_along {
            let [first, last] = [border[0], border[border.len() - 1]].map(|w| subtract(position(w), x));
            squared_distance_to_segment(d, first).min(squared_distance_to_segment(d, last))
        } else {
            let closed: Vec<u32> = border.iter().copied().chain([border[0]; 9]).collect();
            let vertices = &*stretch.vertices;
            let kernel = crate::collapse::guard::SquaredDistances {
                vertices,
                border: &closed,
                origin: [0.0; 3],
                x,
                ends: [position(end); 2],
            };
            dispatch(kernel)[0]
        };
        stretch.errors[end as usize] + squared.sqrt()
    };
    error(ends[0]).max(error(ends[1]))
}
