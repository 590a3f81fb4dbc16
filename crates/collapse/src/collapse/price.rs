//! Prices of edges: the least value of both ends' quadrics together, for each edge once, eight edges at a time.
//!
//! With offsets x from u, d = v - u, and A, B the matrices of u and v, the pair's value is
//! xᵀ(A + B)x - 2 xᵀBd + dᵀBd. Its least value is dᵀBd - zᵀDz for A + B = L D Lᵀ and L D z = Bd.

use crate::collapse::lanes::{EightIndices, EightLanes, Kernel, Vectors, VertexQuadric, dot, mark, pack, subtract};
use crate::collapse::rings::{Rings, RingsView, state};
use crate::collapse::vector::{self, Point};

/// Pivots below this share of the trace count as zero: the planes leave that direction free.
const LEAST_PIVOT: f32 = 1e-6;

/// Squared distance of a placement from the middle of its edge, in squared edges, beyond which an end or the middle is taken.
pub(crate) const REACH: f32 = 4.0;

/// Terms of prices in addition to planes and lines.
#[derive(Clone, Copy)]
pub(crate) struct PriceTerms<'a> {
    /// True if a merged vertex may be anywhere; otherwise it is at one of the two.
    pub moves: bool,
    /// Loss of a vertex' attributes if it is merged into a neighbour, one number per entry of the rings; empty: none.
    pub losses: &'a [f32],
    /// Those of the vertices; attributes count by their importance.
    pub quadrics: &'a [VertexQuadric],
}

impl PriceTerms<'_> {
    fn loss(&self, rings: RingsView, goes: u32, into: u32) -> f32 {
        if self.losses.is_empty() {
            return 0.0;
        }
        let start = rings.starts[goes as usize] as usize;
        let place = rings.ring(goes).iter().position(|&w| w == into);
        let importance = self.quadrics[goes as usize].importance();
        place.map_or(f32::INFINITY, |i| importance * self.losses[start + i])
    }

    /// Returns the price of a merge of `goes` into `stays`, which keeps its place.
    pub(crate) fn price_at(&self, rings: RingsView, goes: u32, stays: u32, d: Point) -> f32 {
        let q = &self.quadrics[goes as usize].0;
        let rows = [[q[0], q[1], q[2]], [q[1], q[3], q[4]], [q[2], q[4], q[5]]];
        let qd = rows.map(|row| vector::dot(row, d));
        vector::dot(qd, d).max(0.0) + self.loss(rings, goes, stays)
    }

    /// Returns what attributes lose where the second goes into the first, or both go to a place between.
    pub(crate) fn find_loss(&self, rings: RingsView, [stays, goes]: [u32; 2], is_fixed: bool) -> f32 {
        if is_fixed { self.loss(rings, goes, stays) } else { self.loss_between(rings, stays, goes) }
    }

    // Of a vertex between both, where each attribute has its best value.
    fn loss_between(&self, rings: RingsView, u: u32, v: u32) -> f32 {
        let (a, b) = (self.loss(rings, u, v), self.loss(rings, v, u));
        if a + b > 0.0 && (a + b).is_finite() { a * b / (a + b) } else { a.min(b) }
    }
}

/// Writes the best edge of each vertex from `first` on into `best`, packed as price and other end.
///
/// Edges are priced from their lower end; what belongs to vertices outside of `best` is added to `elsewhere`.
pub(crate) struct PriceEdges<'a> {
    pub rings: &'a Rings,
    pub terms: PriceTerms<'a>,
    pub first: usize,
    pub best: &'a mut [u64],
    pub elsewhere: &'a mut Vec<(u32, u64)>,
}

impl Kernel for PriceEdges<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: EightLanes>(mut self) {
        let rings = self.rings;
        self.best.fill(u64::MAX);
        let end = self.first + self.best.len();
        // Edges that wait until there are eight, in `us` and `vs`.
        let (mut us, mut vs) = ([0u32; 16], [0u32; 16]);
        let mut n_waiting = 0;
        for u in self.first..end {
            let range = rings.range(u);
            let mut start = range.start;
            while start < range.end {
                let raw: &EightIndices = rings.neighbors[start..].first_chunk().expect("rings are padded");
                let (u_room, v_room) = (room_for_eight(&mut us, n_waiting), room_for_eight(&mut vs, n_waiting));
                n_waiting += L::keep_above(raw, (range.end - start).min(8), u as u32, u_room, v_room);
                start += 8;
                if n_waiting >= 8 {
                    self.price_eight::<L>(first_eight(&us), first_eight(&vs), 8);
                    n_waiting -= 8;
                    us.copy_within(8..16, 0);
                    vs.copy_within(8..16, 0);
                }
            }
        }
        // The last few, filled up with copies of one of them.
        if n_waiting > 0 {
            for i in n_waiting..8 {
                us[i] = us[0];
                vs[i] = vs[0];
            }
            self.price_eight::<L>(first_eight(&us), first_eight(&vs), n_waiting);
        }
        for (best, state) in self.best.iter_mut().zip(&rings.states[self.first..end]) {
            if state & state::RESTS != 0 {
                *best = u64::MAX;
            }
        }
    }
}

#[inline(always)]
fn room_for_eight(x: &mut [u32; 16], start: usize) -> &mut EightIndices {
    x[start & 7..].first_chunk_mut().expect("seven wait at most")
}

#[inline(always)]
fn first_eight(x: &[u32; 16]) -> &EightIndices {
    x.first_chunk().expect("there are sixteen")
}

impl PriceEdges<'_> {
    #[inline(always)]
    fn price_eight<L: EightLanes>(&mut self, us: &EightIndices, vs: &EightIndices, n: usize) {
        let vertices = &self.rings.vertices;
        let d = subtract(L::load_points(vertices, vs), L::load_points(vertices, us));
        let (qu, qv) = (L::load_quadrics(self.terms.quadrics, us), L::load_quadrics(self.terms.quadrics, vs));
        let special = qu[7].max(qv[7]).greater(L::splat(mark::SPECIAL)).to_bits();
        let special = if self.terms.losses.is_empty() { special } else { 255 };
        let prices = if self.terms.moves { price_pairs(&qu, &qv, d) } else { price_either_end(&qu, &qv, d) };
        if special == 0 && L::lower_prices(self.best, self.first as u32, us, vs, prices) {
            return;
        }
        self.lower_one_by_one(us, vs, prices.to_array(), special, n);
    }

    #[inline(never)]
    fn lower_one_by_one(&mut self, us: &EightIndices, vs: &EightIndices, prices: [f32; 8], special: u32, n: usize) {
        for i in 0..n {
            let (u, v) = (us[i], vs[i]);
            let price = if special >> i & 1 != 0 { self.price_special(u, v, prices[i]) } else { prices[i] };
            for (end, other) in [(u, v), (v, u)] {
                match self.best.get_mut((end as usize).wrapping_sub(self.first)) {
                    Some(best) => *best = (*best).min(pack(price, other)),
                    None => self.elsewhere.push((end, pack(price, other))),
                }
            }
        }
    }

    // The price of an edge with an end that is held or refused, or with attributes; `free` is its price otherwise.
    fn price_special(&self, u: u32, v: u32, free: f32) -> f32 {
        let (rings, terms) = (self.rings, self.terms);
        let [su, sv] = [u, v].map(|w| rings.states[w as usize]);
        let is_refused =
            |w: u32, state: u8, other: u32| state & state::REFUSED != 0 && rings.refused[w as usize] == other;
        if is_refused(u, su, v) || is_refused(v, sv, u) {
            return f32::INFINITY;
        }
        let view = rings.view();
        let price_at = |goes: u32, stays: u32| {
            let d = vector::subtract(rings.vertices[stays as usize].position, rings.vertices[goes as usize].position);
            terms.price_at(view, goes, stays, d)
        };
        match (view.may_go((u, su), (v, sv)), view.may_go((v, sv), (u, su))) {
            (true, true) if terms.moves => free + terms.loss_between(view, u, v),
            (true, true) => price_at(u, v).min(price_at(v, u)),
            (true, false) => price_at(u, v),
            (false, true) => price_at(v, u),
            (false, false) => f32::INFINITY,
        }
    }
}

/// Returns the least values of pairs of quadrics whose vertices are `d` apart.
#[inline(always)]
fn price_pairs<L: EightLanes>(qu: &[L; 8], qv: &[L; 8], d: Vectors<L>) -> L {
    let [x, y, z] = d;
    let a = [qu[0] + qv[0], qu[1] + qv[1], qu[2] + qv[2], qu[3] + qv[3], qu[4] + qv[4], qu[5] + qv[5]];
    // b = Bd and c = dᵀBd.
    let b0 = qv[0] * x + (qv[1] * y + qv[2] * z);
    let b1 = qv[1] * x + (qv[3] * y + qv[4] * z);
    let b2 = qv[2] * x + (qv[4] * y + qv[5] * z);
    let c = b0 * x + (b1 * y + b2 * z);
    // L D Lᵀ of A + B, with inverse pivots; a pivot of a free direction has none.
    let least = L::splat(LEAST_PIVOT) * (a[0] + (a[3] + a[5]));
    let one = L::splat(1.0);
    let inverse0 = a[0].greater(least).and(one / a[0]);
    let (l10, l20) = (a[1] * inverse0, a[2] * inverse0);
    let pivot1 = a[3] - l10 * a[1];
    let rest = a[4] - l20 * a[1];
    let inverse1 = pivot1.greater(least).and(one / pivot1);
    let l21 = rest * inverse1;
    let pivot2 = (a[5] - l20 * a[2]) - l21 * rest;
    let inverse2 = pivot2.greater(least).and(one / pivot2);
    let y1 = b1 - l10 * b0;
    let y2 = (b2 - l20 * b0) - l21 * y1;
    let (z0, z1, z2) = (b0 * inverse0, y1 * inverse1, y2 * inverse2);
    let price = ((c - b0 * z0) - y1 * z1) - y2 * z2;
    // The placement, seen from the middle; one far away is not taken.
    let x1 = z1 - l21 * z2;
    let x0 = (z0 - l10 * x1) - l20 * z2;
    let half = L::splat(0.5);
    let off = [x0 - half * x, x1 - half * y, z2 - half * z];
    let is_far = dot(off, off).greater(L::splat(REACH) * dot(d, d));
    is_far.select(price_ends(&a, d, c), price).max(L::splat(0.0))
}

// The lesser value of v's quadric at u and of u's at v.
#[inline(always)]
fn price_either_end<L: EightLanes>(qu: &[L; 8], qv: &[L; 8], d: Vectors<L>) -> L {
    apply_form(qu, d).min(apply_form(qv, d)).max(L::splat(0.0))
}

#[inline(always)]
fn apply_form<L: EightLanes>(q: &[L; 8], [x, y, z]: Vectors<L>) -> L {
    let qx = q[0] * x + (q[1] * y + q[2] * z);
    let qy = q[1] * x + (q[3] * y + q[4] * z);
    let qz = q[2] * x + (q[4] * y + q[5] * z);
    qx * x + (qy * y + qz * z)
}

// The least value at u, at v and in the middle, where `c` is the value at u.
#[inline(always)]
fn price_ends<L: EightLanes>(a: &[L; 6], d: Vectors<L>, c: L) -> L {
    let [x, y, z] = d;
    let ax = a[0] * x + (a[1] * y + a[2] * z);
    let ay = a[1] * x + (a[3] * y + a[4] * z);
    let az = a[2] * x + (a[4] * y + a[5] * z);
    // At v it is dᵀ(A + B)d - c, in the middle a quarter of that form.
    let form = ax * x + (ay * y + az * z);
    (form - c).min(c).min(L::splat(0.25) * form)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collapse::lanes::{dispatch, run_plain};
    use crate::collapse::quadric::SumQuadrics;
    use crate::collapse::tests::meshes;

    // The least value of the pair, by the placement in doubles.
    fn price_naively(qu: &VertexQuadric, qv: &VertexQuadric, d: [f32; 3]) -> f64 {
        let x = crate::collapse::placement::place_naively(qu, qv, d);
        crate::collapse::placement::value_naively(qu, qv, d, x)
    }

    #[test]
    fn the_best_edges_are_those_of_the_naive_twin() {
        let rings = meshes::bumpy_torus(24, 12).to_rings();
        let n = rings.vertices.len();
        let mut quadrics = vec![VertexQuadric::default(); n];
        dispatch(SumQuadrics { rings: &rings, first: 0, out: &mut quadrics });
        let (mut best, mut elsewhere) = (vec![0; n], Vec::new());
        dispatch(PriceEdges {
            rings: &rings,
            terms: PriceTerms { moves: true, losses: &[], quadrics: &quadrics },
            first: 0,
            best: &mut best,
            elsewhere: &mut elsewhere,
        });
        assert!(elsewhere.is_empty());
        for u in 0..n {
            let price = |v: u32| {
                let d = vector::subtract(rings.vertices[v as usize].position, rings.vertices[u].position);
                price_naively(&quadrics[u], &quadrics[v as usize], d)
            };
            let least = rings.ring(u).iter().map(|&v| price(v)).fold(f64::INFINITY, f64::min);
            let found = f64::from(f32::from_bits((best[u] >> 32) as u32));
            assert!((found - least).abs() <= 1e-3 * least + 1e-9, "{u}: {found} {least}");
            assert!((price(best[u] as u32) - least).abs() <= 1e-3 * least + 1e-9);
        }
    }

    #[test]
    fn pieces_give_what_the_whole_gives_on_all_lanes() {
        let rings = meshes::terrain(12).to_rings();
        let n = rings.vertices.len();
        let mut quadrics = vec![VertexQuadric::default(); n];
        dispatch(SumQuadrics { rings: &rings, first: 0, out: &mut quadrics });
        let price = |size: usize, is_plain: bool| {
            let (mut best, mut elsewhere) = (vec![0; n], Vec::new());
            for (i, best) in best.chunks_mut(size).enumerate() {
                let first = i * size;
                let terms = PriceTerms { moves: true, losses: &[], quadrics: &quadrics };
                let kernel = PriceEdges { rings: &rings, terms, first, best, elsewhere: &mut elsewhere };
                if is_plain { run_plain(kernel) } else { dispatch(kernel) }
            }
            for (v, packed) in elsewhere {
                best[v as usize] = best[v as usize].min(packed);
            }
            best
        };
        let whole = price(n, false);
        assert_eq!(price(17, false), whole);
        assert_eq!(price(50, true), whole);
    }
}
