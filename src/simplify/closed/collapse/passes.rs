//! The order of a collapse: passes, each with prices of its own.
//!
//! Before a pass the quadrics are those of the present faces, every edge is priced once, and every vertex knows its cheapest edge. The
//! pass takes the vertices whose edge is among the cheapest, as many as merges are left to do, in the order of memory. Each is merged with
//! its neighbour unless one of them was merged in this pass already; no price is computed again within a pass. Whatever is left to do goes
//! to the next pass, over what is left of the mesh. So every price is one of the present surface, and no queue is kept. The last passes go
//! in the order of price.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use rayon::prelude::*;

use crate::linalg::{Isa, Work};
use crate::mesh::pulse::PARALLEL;
use crate::mesh::shares::indices_where;
use crate::simplify::limits::Limit;

use super::cheapest::Cheapest;
use super::complex::{Collapse, End, GONE};
use super::pair::{Changed, Node, WIDTH, prices};

/// Vertices that a pass takes, for each merge that is left to do. Thirteen training meshes at ratios of 0.05, 0.2 and 0.5: at 1.5 the mean
/// distance is 24 % farther, at 0.6 the same, in more passes.
const SHARE: f64 = 1.0;
/// The same in the last passes, where many of the cheapest edges share their ends. The same meshes: 2 and 6 move the mean distance by
/// 0.5 %.
const SHARE_OF_LAST: f64 = 3.5;
/// Merges that are left to do, of all of them, from which on passes go in the order of price. The same meshes: at 0.05 the mean distance
/// is 9 % farther, at 0.002 the same.
const LAST: f64 = 0.01;
/// Vertices that a pass takes at least, if it has as many merges to do.
const LEAST: usize = 64;
/// By how much more vertices a pass takes after one in vain.
const RISE: usize = 8;
/// Passes in vain, one after the other, after which one tries every edge.
const MOST_IN_VAIN: i32 = 3;
/// How much lower an edge may be priced anew that waits for its turn, and count as not tried.
const SLACK: f32 = 0.999;
/// Faces whose edges are priced by one thread, one after the other.
const TOGETHER: usize = 1 << 13;
/// Edges that are gathered before they are priced.
const BATCH: usize = 128;
/// Vertices that are visited between two beats: a few milliseconds.
const BETWEEN_BEATS: usize = 4096;

/// A vertex whose turn it is.
#[derive(Clone, Copy)]
struct Candidate {
    price: f32,
    vertex: u32,
    edge: u32,
}

/// Pricing the edges of some faces, as work that is compiled for the instructions at hand.
struct Pricing<'a, 'b> {
    collapse: &'a Collapse<'b>,
    /// The faces; of the two at an edge the first one counts.
    faces: Range<usize>,
    /// Whether the cheapest edge of each vertex is not known; empty where none is.
    is_unknown: &'a [bool],
    /// The cheapest edge of each vertex so far.
    cheapest: &'a [AtomicU64],
    /// Whether no other thread prices edges.
    is_alone: bool,
}

/// An edge to be priced.
#[derive(Clone, Copy, Default)]
struct Edge {
    ends: [u32; 2],
    number: u32,
}

impl Work for Pricing<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (mut edges, mut n) = ([Edge::default(); BATCH + 4], 0);
        for (first, [a, b, c], across) in self.collapse.corners.faces_in(self.faces.clone()) {
            if self.are_known([a, b, c]) {
                continue;
            }
            for (k, ends) in [[b, c], [c, a], [a, b]].into_iter().enumerate() {
                let number = first + k as u32;
                edges[n] = Edge { ends, number };
                // Without a branch: nobody can guess which way it would go.
                let is_own = !self.collapse.is_ghost(ends[0].max(ends[1]));
                n += usize::from((number < across[k]) & is_own & !self.are_known(ends));
            }
            if n > BATCH {
                self.price(&edges[..n]);
                n = 0;
            }
        }
        self.price(&edges[..n]);
    }
}

impl Pricing<'_, '_> {
    /// Whether the cheapest edges of all these vertices are known.
    #[inline(always)]
    fn are_known<const N: usize>(&self, vertices: [u32; N]) -> bool {
        let is_known = |v: u32| self.is_unknown.get(v as usize).is_some_and(|unknown| !unknown);
        !self.is_unknown.is_empty() && vertices.into_iter().fold(true, |all, v| all & is_known(v))
    }

    /// Prices edges, eight side by side, and tells their ends.
    #[inline(always)]
    fn price(&self, edges: &[Edge]) {
        for edges in edges.chunks(WIDTH) {
            // Where there are fewer, the first edge stands in the other places, too.
            let node = |edge: &Edge, end: usize| &self.collapse.nodes[edge.ends[end] as usize];
            let mut ends = [[node(&edges[0], 0); WIDTH], [node(&edges[0], 1); WIDTH]];
            for (i, edge) in edges.iter().enumerate().skip(1) {
                (ends[0][i], ends[1][i]) = (node(edge, 0), node(edge, 1));
            }
            for (edge, price) in edges.iter().zip(prices(ends)) {
                self.note(edge, price);
            }
        }
    }

    /// Tells the ends of an edge what it costs.
    #[inline(always)]
    fn note(&self, edge: &Edge, plain: f32) {
        let is_special = self.collapse.is_special_edge(edge.ends);
        let price = if is_special { self.collapse.constrained_price(edge.ends[0], edge.ends[1]) } else { plain };
        let known = Cheapest::new(price, edge.number);
        for v in edge.ends {
            let cheapest = &self.cheapest[v as usize];
            if self.is_alone {
                cheapest.store(cheapest.load(Relaxed).min(known.0), Relaxed);
            } else {
                cheapest.fetch_min(known.0, Relaxed);
            }
        }
    }
}

/// The visits of a pass, as work that is compiled for the instructions at hand.
struct Visits<'a, 'b> {
    collapse: &'a mut Collapse<'b>,
    candidates: &'a [Candidate],
    most: f32,
    limit: Limit,
}

impl Work for Visits<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for candidates in self.candidates.chunks(BETWEEN_BEATS) {
            let n_before = self.collapse.n_vertices;
            for candidate in candidates {
                if self.collapse.reached(self.limit) {
                    break;
                }
                self.collapse.visit(candidate, self.most);
            }
            self.collapse.pulse.beat(n_before - self.collapse.n_vertices);
        }
    }
}

impl Collapse<'_> {
    /// Collapses the cheapest edges until the limit or until none may go.
    pub fn run(&mut self, limit: Limit) -> End {
        if self.plane().is_some() { self.run_half(limit) } else { self.run_to(limit) }
    }

    /// Collapses down to the limit or until no edge may go.
    pub(super) fn run_to(&mut self, limit: Limit) -> End {
        let n_all = self.merges_to(limit);
        let mut n_in_vain = 0;
        while !self.reached(limit) {
            self.keep_copy(limit);
            self.begin_pass();
            if n_in_vain >= MOST_IN_VAIN {
                self.try_all_again();
            }
            let is_last = self.merges_to(limit) as f64 <= LAST * n_all as f64;
            let (candidates, most) = self.candidates(limit, n_in_vain, is_last);
            let before = self.n_vertices;
            Isa::best().run(Visits { collapse: self, candidates: &candidates, most, limit });
            if self.n_vertices < before {
                let highest = candidates.iter().map(|candidate| candidate.price).fold(0.0, f32::max);
                self.paid.push((self.n_vertices, highest));
                n_in_vain = 0;
            } else if n_in_vain >= MOST_IN_VAIN {
                return self.end_without_edges(limit);
            } else {
                n_in_vain += 1;
            }
        }
        End::Reached
    }

    /// How a run ended where no edge may go.
    fn end_without_edges(&self, limit: Limit) -> End {
        match (&self.constraints, self.turn_forbidden) {
            _ if limit.price < f32::INFINITY => End::Reached,
            _ if self.ceiling_met => End::LosesShape,
            (Some(constraints), _) if constraints.hold_more_than_plane() => End::Held,
            (_, true) => End::WouldTurn,
            (Some(_), _) => End::SmallestMirrored,
            _ => End::Smallest,
        }
    }

    /// Moves what is left together, sums its quadrics and prices its edges anew.
    pub(super) fn begin_pass(&mut self) {
        self.compact();
        let stale = self.renew();
        self.pass += 1;
        self.price(&stale);
    }

    /// Lets every edge be tried again.
    fn try_all_again(&mut self) {
        self.nodes.iter_mut().for_each(|node| node.wait = 0.0);
        (self.turn_forbidden, self.ceiling_met) = (false, false);
    }

    /// The vertices whose turn it is, and up to which price.
    fn candidates(&self, limit: Limit, n_in_vain: i32, is_last: bool) -> (Vec<Candidate>, f32) {
        let to_do = self.merges_to(limit);
        let share = if is_last { SHARE_OF_LAST } else { SHARE };
        let n = ((to_do as f64 * share) as usize).max(LEAST.min(to_do)).saturating_mul(RISE.pow(n_in_vain as u32));
        let price = |(cheapest, node): (&Cheapest, &Node)| cheapest.price().max(node.wait);
        let priced = self.cheapest.par_iter().zip(&self.nodes).with_min_len(PARALLEL);
        let prices: Vec<f32> = priced.map(price).collect();
        let most = if n_in_vain >= MOST_IN_VAIN { f32::MAX } else { nth_price(&prices, n) };
        let most = most.min(limit.price);
        let pulse = self.pulse.counting_if(false);
        let taken = indices_where(pulse, &prices, |_, price| *price <= most);
        let edge = |vertex: u32| self.cheapest[vertex as usize].edge();
        let candidate = |&vertex: &u32| Candidate { price: prices[vertex as usize], vertex, edge: edge(vertex) };
        let mut candidates = pulse.map(&taken, candidate);
        if is_last {
            candidates.sort_unstable_by(|x, y| x.price.total_cmp(&y.price).then(x.vertex.cmp(&y.vertex)));
        }
        (candidates, most)
    }

    /// Prices the edges whose prices may have changed: the cheapest edge of every vertex is known then.
    fn price(&mut self, stale: &[u32]) {
        let is_unknown = if self.cheapest.is_empty() { Vec::new() } else { self.beside(stale) };
        let mut known = std::mem::take(&mut self.cheapest);
        known.resize(self.n_inner, Cheapest::NONE);
        let is_known = |v: usize| is_unknown.get(v).is_some_and(|unknown| !unknown) && self.nodes[v].corner != GONE;
        let so_far = |(v, known): (usize, Cheapest)| AtomicU64::new(if is_known(v) { known.0 } else { u64::MAX });
        let cheapest: Vec<AtomicU64> = known.into_iter().enumerate().map(so_far).collect();
        let n_faces = self.corners.n_faces();
        let chunks = (0..n_faces).step_by(TOGETHER).map(|first| first..(first + TOGETHER).min(n_faces));
        let is_alone = rayon::current_num_threads() == 1;
        chunks.collect::<Vec<_>>().into_par_iter().for_each(|faces| {
            self.pulse.beat(0);
            Isa::best().run(Pricing { collapse: self, faces, is_unknown: &is_unknown, cheapest: &cheapest, is_alone });
        });
        self.cheapest = cheapest.into_iter().map(|cheapest| Cheapest(cheapest.into_inner())).collect();
    }

    /// Whether each vertex is one of these or beside one; empty where most are.
    fn beside(&self, vertices: &[u32]) -> Vec<bool> {
        if vertices.len() * 4 > self.n_inner {
            return Vec::new();
        }
        let mut is_beside = vec![false; self.nodes.len()];
        for &v in vertices {
            is_beside[v as usize] = true;
            self.neighbors(v).for_each(|w| is_beside[w as usize] = true);
        }
        is_beside
    }

    /// Whether the price of an edge is set by more than the planes of its ends.
    #[inline(always)]
    fn is_special_edge(&self, ends: [u32; 2]) -> bool {
        !self.is_special.is_empty() && self.ids(ends).into_iter().any(|id| self.is_special[id as usize])
    }

    /// Merges a vertex with the neighbour that costs least, if one at this price at most may be merged with it.
    #[inline(always)]
    fn visit(&mut self, &Candidate { vertex, edge, .. }: &Candidate, most: f32) {
        if self.was_merged(vertex) {
            return;
        }
        let is_first = self.nodes[vertex as usize].wait == 0.0;
        let is_taken = || self.corners.edge(edge).into_iter().any(|v| self.was_merged(v));
        if is_first && (is_taken() || self.try_merge(vertex, edge)) {
            return;
        }
        self.try_others(vertex, is_first.then_some(edge), most);
    }

    /// Whether a vertex was merged in this pass; so was one at a corner whose face went since.
    #[inline(always)]
    fn was_merged(&self, v: u32) -> bool {
        self.nodes.get(v as usize).is_none_or(|node| node.changed == Changed::merged_in(self.pass))
    }

    /// Tries the other edges of a vertex by their prices, where the cheapest may not go.
    #[inline(never)]
    fn try_others(&mut self, v: u32, tried: Option<u32>, most: f32) {
        let least = SLACK * self.nodes[v as usize].wait;
        let edges = self.edges_at(v);
        let others = edges.into_iter().filter(|&(price, edge)| price >= least && Some(edge) != tried);
        let mut next = f32::INFINITY;
        for (price, edge) in others {
            if price > most {
                next = price;
                break;
            }
            if !self.corners.edge(edge).into_iter().any(|w| self.was_merged(w)) && self.try_merge(v, edge) {
                return;
            }
        }
        // What has changed beside it may let go what was held.
        let node = &mut self.nodes[v as usize];
        node.wait = if node.changed.is_in(self.pass) { 0.0 } else { next };
    }

    /// The edges of a vertex that have a price, the cheapest first.
    pub(super) fn edges_at(&self, v: u32) -> Vec<(f32, u32)> {
        let mut edges = Vec::with_capacity(self.nodes[v as usize].degree as usize);
        for step in self.faces_around(v) {
            let w = self.corners.vertex(step.from);
            if !self.is_ghost(w) {
                let price = self.constrained_price(v.min(w), v.max(w)).max(0.0);
                edges.push((price, self.corners.number_of_edge(step.opposite())));
            }
        }
        edges.retain(|(price, _)| *price < f32::INFINITY);
        edges.sort_unstable_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
        edges
    }
}

/// The n-th least of these prices, of those that are finite; the largest one where there are fewer.
fn nth_price(prices: &[f32], n: usize) -> f32 {
    let mut finite: Vec<f32> = prices.iter().copied().filter(|price| *price < f32::INFINITY).collect();
    match finite.len() {
        0 => 0.0,
        n_finite => *finite.select_nth_unstable_by(n.clamp(1, n_finite) - 1, f32::total_cmp).1,
    }
}
