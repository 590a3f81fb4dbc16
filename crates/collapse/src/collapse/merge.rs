//! The merge of two vertices inside the surface, by lanes of eight faces.
//!
//! ```text
//!          b0                           b0            u stays and moves to x, v goes
//!        / || \                       / || \          border b0 b1 ... of the star, in cyclic order:
//!      bn--u---v--b(n-1)    merge    bn--x--b(n-1)      first the other neighbours of u, of which the first
//!        \ || /            ----->     \ || /            and the last are those of v, too, then the rest of v's
//!         b(m)                          b(m)          a face of the star is x and two of the border in a row
//! ```
//!
//! All coordinates are seen from u.

use crate::collapse::guard::SquaredDistances;
use crate::collapse::lanes::{EightIndices, EightLanes, Vectors, VertexQuadric, cross, dot, splat_vector, subtract};
use crate::collapse::placement::{VolumePlane, place_pair};
use crate::collapse::rings::Vertex;
use crate::collapse::stretch::{PassView, Refusal, VertexStretch};
use crate::collapse::vector::{self, Point};

/// Least cosine, squared, between a face's normals before and after a merge: 60 degrees.
///
/// At 78 degrees, 14 in place of 5 faces are turned over in 96 results.
pub(crate) const LEAST_COSINE_SQUARED: f32 = 0.25;

/// Height of a face over its edge, squared, below which a merge may not bring it.
const THINNEST_SQUARED: f32 = 1e-10;

/// Cosine, squared, between a normal and the star's mean from which on the face counts as flat: 60 degrees.
const FLAT_COSINE_SQUARED: f32 = 0.25;

/// Limits of the guard that the estimated error of a flat star may reach.
///
/// 2 costs 8 % of the mean distance; without a bound the largest distance is 3 % larger.
const FLAT_LIMIT: f32 = 4.0;

/// The border of a star, in room that grows with the largest degree.
#[derive(Default)]
pub(crate) struct Border {
    /// The vertices, counted within the stretch, then copies of the first for loads of eight.
    vertices: Vec<u32>,
    n: usize,
    /// How many are neighbours of u.
    n_u: usize,
}

/// The ends of an edge to merge: `u` stays.
#[derive(Clone, Copy)]
pub(crate) struct EdgeToMerge {
    pub u: u32,
    pub v: u32,
    /// The price of the edge.
    pub price: f32,
    /// The part of the price that attributes lose.
    pub loss: f32,
    /// True if the merged vertex is at u.
    pub is_fixed: bool,
}

impl EdgeToMerge {
    /// Returns what attributes lose, as a distance.
    #[inline(always)]
    pub(crate) fn measure_loss(&self, qu: &VertexQuadric, qv: &VertexQuadric) -> f32 {
        (self.loss / (qu.0[6] + qv.0[6]).max(1e-37)).sqrt()
    }
}

/// Merges v into u, both inside the surface; removes two faces and returns the place and v, both seen from u.
#[inline(always)]
pub(crate) fn merge_inside<L: EightLanes>(
    pass: &PassView,
    stretch: &mut VertexStretch,
    border: &mut Border,
    edge: EdgeToMerge,
) -> Result<[Point; 2], Refusal> {
    border.trace(pass, stretch, edge.u, edge.v)?;
    border.check_link(stretch)?;
    let (u, v) = (edge.u - stretch.first, edge.v - stretch.first);
    let pu = stretch.vertices[u as usize].position;
    let d = vector::subtract(stretch.vertices[v as usize].position, pu);
    let star = EdgeStar { vertices: stretch.vertices, border, origin: splat_vector::<L>(pu), d: splat_vector(d) };
    let plane = star.sum_volume();
    let (qu, qv) = (&pass.terms.quadrics[edge.u as usize], &pass.terms.quadrics[edge.v as usize]);
    let x = if edge.is_fixed { [0.0; 3] } else { place_pair(qu, qv, d, Some(plane)) };
    let is_flat = star.check_turns(x, plane.normal)?;
    // Errors add up over passes. On a flat star planes tell how far the surface moves.
    let (eu, ev) = (stretch.errors[u as usize], stretch.errors[v as usize]);
    let error = if is_flat {
        eu.max(ev) + (edge.price / (qu.0[6] + qv.0[6]).max(1e-37)).sqrt()
    } else {
        let kernel =
            SquaredDistances { vertices: stretch.vertices, border: border.close(), origin: pu, x, ends: [[0.0; 3], d] };
        let [du, dv] = L::run_apart(kernel);
        (eu + du.sqrt()).max(ev + dv.sqrt()) + edge.measure_loss(qu, qv)
    };
    let limit = if is_flat { FLAT_LIMIT * pass.guard } else { pass.guard };
    if error > limit.min(pass.max_error) {
        return Err(Refusal::Guard);
    }
    let position = [pu[0] + x[0], pu[1] + x[1], pu[2] + x[2]];
    stretch.write_merge(u, v, position, border.n, error);
    let [side, other_side] = border.sides();
    stretch.degrees[side as usize] -= 1;
    stretch.degrees[other_side as usize] -= 1;
    Ok([x, d])
}

impl Border {
    /// The border, and the first vertex once more.
    fn close(&self) -> &[u32] {
        &self.vertices[..self.n + 9]
    }

    /// Returns the border, and how many of it are neighbours of u.
    pub(crate) fn vertices(&self) -> (&[u32], usize) {
        (&self.vertices[..self.n], self.n_u)
    }

    fn sides(&self) -> [u32; 2] {
        [self.vertices[0], self.vertices[self.n_u - 1]]
    }

    // Walks around u from behind v, then around v from behind u; survivors of this pass's merges come once.
    #[inline(always)]
    fn trace(&mut self, pass: &PassView, stretch: &VertexStretch, u: u32, v: u32) -> Result<(), Refusal> {
        let (ring_u, ring_v) = (pass.rings.ring(u), pass.rings.ring(v));
        let (Some(at_v), Some(at_u)) = (find(ring_u, v), find(ring_v, u)) else { return Err(Refusal::Topology) };
        let room = ring_u.len() + ring_v.len() + 16;
        if self.vertices.len() < room {
            self.vertices.resize(2 * room, 0);
        }
        let out = &mut self.vertices[..room];
        let (mut n, mut last) = (0, u32::MAX);
        for (ring, at, is_u) in [(ring_u, at_v, true), (ring_v, at_u, false)] {
            let mut i = at;
            for _ in 1..ring.len() {
                i += 1;
                if i == ring.len() {
                    i = 0;
                }
                let Some(w) = stretch.survivor(ring[i]) else { return Err(Refusal::Outside) };
                out[n] = w;
                n += usize::from(w != last);
                last = w;
            }
            if is_u {
                self.n_u = n;
            }
        }
        // The walk ends where it began: the last is the first.
        let is_closed = n >= 4 && self.n_u >= 2 && n > self.n_u && last == out[0];
        if !is_closed {
            return Err(Refusal::Topology);
        }
        self.n = n - 1;
        let first = out[0];
        for w in &mut out[n - 1..n + 8] {
            *w = first;
        }
        Ok(())
    }

    // Only the two sides may be neighbours of both ends, and each has to keep three neighbours.
    #[inline(always)]
    fn check_link(&self, stretch: &VertexStretch) -> Result<(), Refusal> {
        let (of_u, of_v) = self.vertices[..self.n].split_at(self.n_u);
        let mut seen = 0u64;
        for &w in of_u {
            seen |= 1 << (w & 63);
        }
        for &w in of_v {
            if seen >> (w & 63) & 1 != 0 && of_u.contains(&w) {
                return Err(Refusal::Topology);
            }
        }
        if self.sides().iter().any(|&w| stretch.has_least_degree(w)) {
            return Err(Refusal::Topology);
        }
        Ok(())
    }
}

#[inline(always)]
fn find(ring: &[u32], vertex: u32) -> Option<usize> {
    ring.iter().position(|&w| w == vertex)
}

/// The star around an edge, seen from u.
struct EdgeStar<'a, L> {
    vertices: &'a [Vertex],
    border: &'a Border,
    origin: Vectors<L>,
    /// v - u
    d: Vectors<L>,
}

impl<L: EightLanes> EdgeStar<'_, L> {
    /// Eight edges of the border: cross products of their ends, and the edges.
    #[inline(always)]
    fn load_edges(&self, j: usize) -> (Vectors<L>, Vectors<L>) {
        let ids = &self.border.vertices[8 * j..8 * j + 9];
        let at: &EightIndices = ids.first_chunk().expect("there are nine");
        let next: &EightIndices = ids.last_chunk().expect("there are nine");
        let a = subtract(L::load_points(self.vertices, at), self.origin);
        let b = subtract(L::load_points(self.vertices, next), self.origin);
        (cross(a, b), subtract(b, a))
    }

    /// Masks of the eight edges that exist, and of those with v in their face.
    #[inline(always)]
    fn masks(&self, j: usize) -> (L, L) {
        let live = L::mask_first(self.border.n - 8 * j);
        let in_u = L::mask_first((self.border.n_u - 1).saturating_sub(8 * j));
        (live, in_u.select(L::splat(0.0), live))
    }

    /// Sums the normals of the star and six times the volume between its faces and the origin.
    ///
    /// Every x with normal · x = offset keeps that volume.
    #[inline(always)]
    fn sum_volume(&self) -> VolumePlane {
        let zero = L::splat(0.0);
        let mut sums = [zero; 4];
        for j in 0..self.border.n.div_ceil(8) {
            let (c, _) = self.load_edges(j);
            let (live, in_v) = self.masks(j);
            for k in 0..3 {
                sums[k] = sums[k] + live.and(c[k]);
            }
            sums[3] = sums[3] + in_v.and(dot(self.d, c));
        }
        let [x, y, z, offset] = L::sum_four_rows(sums);
        VolumePlane { normal: [x, y, z], offset }
    }

    /// Refuses a placement at which a face turns; else returns whether all faces are near the mean normal.
    #[inline(always)]
    fn check_turns(&self, x: [f32; 3], mean: [f32; 3]) -> Result<bool, Refusal> {
        let (x, zero) = (splat_vector(x), L::splat(0.0));
        let mean_squared = L::splat(FLAT_COSINE_SQUARED * vector::dot(mean, mean));
        let mean = splat_vector(mean);
        let mut is_flat = true;
        for j in 0..self.border.n.div_ceil(8) {
            let (c, edge) = self.load_edges(j);
            let (live, in_v) = self.masks(j);
            let tip = [in_v.and(self.d[0]), in_v.and(self.d[1]), in_v.and(self.d[2])];
            let old = subtract(c, cross(tip, edge));
            let new = subtract(c, cross(x, edge));
            let (along, new_squared) = (dot(old, new), dot(new, new));
            let bound = L::splat(LEAST_COSINE_SQUARED) * dot(old, old) * new_squared;
            // A face that becomes a line has no normal that the next merge could keep.
            let squared = dot(edge, edge);
            let thin = (L::splat(THINNEST_SQUARED) * squared * squared).min(L::splat(0.5) * dot(old, old));
            let keeps =
                along.greater(zero).and((along * along).greater(bound)).and(new_squared.greater(thin)).to_bits();
            let live = live.to_bits() & 255;
            if keeps & live != live {
                return Err(Refusal::Turn);
            }
            let rise = dot(new, mean);
            let flat = rise.greater(zero).and((rise * rise).greater(mean_squared * new_squared)).to_bits();
            is_flat &= flat & live == live;
        }
        Ok(is_flat)
    }
}
