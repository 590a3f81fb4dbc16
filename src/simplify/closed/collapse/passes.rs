//! Passes of a collapse: merges at the cheapest prices of the present surface.

use std::ops::Range;

use rayon::prelude::*;

use crate::linalg::{Isa, Work};
use crate::mesh::pulse::PARALLEL;
use crate::mesh::thread_ranges::indices_where;
use crate::simplify::limits::Limit;

use super::cheapest_edge::CheapestEdge;
use super::history::CollapseEvent;
use super::merge::{Candidate, Merger, Merges};
use super::pair::{CollapseVertex, WIDTH, prices};
use super::rules::Rules;
use super::state::{Collapse, CollapseEnd, REMOVED, merges_to, whole_size};
use super::stretch::{self, StretchEnd};

/// Vertices visited by a pass, per remaining merge.
// Thirteen meshes: at 1.5 the mean distance is 24 % larger, at 0.6 equal, in more passes.
const VISITS_PER_MERGE: f64 = 1.0;
/// Vertices visited per remaining merge in the last passes.
// Cheap edges share ends there. 2 and 6 change the mean distance by 0.5 %.
const LAST_VISITS_PER_MERGE: f64 = 3.5;
/// Share of the merges, the last ones, made in the order of price.
// The mean distance is 9 % larger at 0.05 and equal at 0.002.
const LAST_SHARE: f64 = 0.01;
const LEAST_VISITS: usize = 64;
/// Factor on the number of visited vertices after a pass without a merge.
const VISIT_GROWTH: usize = 8;
/// Consecutive passes without a merge after which all edges are tried.
const MOST_IDLE_PASSES: i32 = 3;
const BATCH: usize = 128;
const BETWEEN_BEATS: usize = 4096;

struct Pricing<'a, 'b> {
    collapse: &'a Collapse<'b>,
    /// Faces to price; an edge belongs to the face with the smaller of its opposite corners.
    faces: Range<usize>,
    /// Marks vertices without a known cheapest edge; empty to mark all.
    is_unknown: &'a [bool],
    first_vertex: u32,
    cheapest: &'a mut [CheapestEdge],
    /// Edges of vertices outside of `cheapest`.
    others: Vec<(u32, CheapestEdge)>,
}

#[derive(Clone, Copy, Default)]
struct PricedEdge {
    ends: [u32; 2],
    number: u32,
}

impl Work for Pricing<'_, '_> {
    type Output = Vec<(u32, CheapestEdge)>;

    #[inline(always)]
    fn run(mut self) -> Self::Output {
        let (mut edges, mut n) = ([PricedEdge::default(); BATCH + 4], 0);
        for (first, [a, b, c], across) in self.collapse.corners.faces_in(self.faces.clone()) {
            if self.are_known([a, b, c]) {
                continue;
            }
            for (k, ends) in [[b, c], [c, a], [a, b]].into_iter().enumerate() {
                // Each edge is priced from the face whose corner gives its number.
                let number = first + k as u32;
                edges[n] = PricedEdge { ends, number };
                // No branch: it would be mispredicted too often.
                let is_own = !self.collapse.is_ghost(ends[0].max(ends[1]));
                n += usize::from((number < across[k]) & is_own & !self.are_known(ends));
            }
            if n > BATCH {
                self.price(&edges[..n]);
                n = 0;
            }
        }
        self.price(&edges[..n]);
        self.others
    }
}

impl Pricing<'_, '_> {
    #[inline(always)]
    fn are_known<const N: usize>(&self, vertices: [u32; N]) -> bool {
        let is_known = |v: u32| self.is_unknown.get(v as usize).is_some_and(|unknown| !unknown);
        !self.is_unknown.is_empty() && vertices.into_iter().fold(true, |all, v| all & is_known(v))
    }

    #[inline(always)]
    fn price(&mut self, edges: &[PricedEdge]) {
        for edges in edges.chunks(WIDTH) {
            // Groups of fewer than eight are filled with the first edge.
            let node = |edge: &PricedEdge, end: usize| &self.collapse.nodes[edge.ends[end] as usize];
            let mut ends = [[node(&edges[0], 0); WIDTH], [node(&edges[0], 1); WIDTH]];
            for (i, edge) in edges.iter().enumerate().skip(1) {
                (ends[0][i], ends[1][i]) = (node(edge, 0), node(edge, 1));
            }
            for (edge, price) in edges.iter().zip(prices(ends)) {
                self.update_cheapest(edge, price);
            }
        }
    }

    #[inline(always)]
    fn update_cheapest(&mut self, edge: &PricedEdge, plain: f32) {
        // Eight plain prices are computed at once; constraints, attributes and poses replace a few.
        let is_special = self.collapse.is_special_edge(edge.ends);
        let nodes = || edge.ends.map(|v| &self.collapse.nodes[v as usize]);
        let price = if is_special { self.collapse.rules.price(nodes()) } else { plain };
        let priced = CheapestEdge::new(price, edge.number);
        for v in edge.ends {
            match self.cheapest.get_mut(v.wrapping_sub(self.first_vertex) as usize) {
                Some(cheapest) => *cheapest = priced.min(*cheapest),
                None => self.others.push((v, priced)),
            }
        }
    }
}

struct Visits<'a, 'm> {
    merger: &'a mut Merger<'m>,
    candidates: &'a [Candidate],
    most_price: f32,
    has_reached: &'a dyn Fn(&Merger) -> bool,
}

impl Work for Visits<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for candidate in self.candidates {
            if (self.has_reached)(self.merger) {
                break;
            }
            self.merger.visit(candidate, self.most_price);
        }
    }
}

impl Collapse<'_> {
    /// Collapses the cheapest edges until the limit, or until no merge is possible.
    pub fn run(&mut self, limit: Limit) -> CollapseEnd {
        if self.plane().is_some() { self.run_half(limit) } else { self.run_to(limit) }
    }

    pub(super) fn run_to(&mut self, limit: Limit) -> CollapseEnd {
        let n_all = self.merges_to(limit);
        let mut n_idle_passes = 0;
        while !self.has_reached(limit) {
            // The copy for dropped components must be made before the pass that goes below its size.
            self.make_copy_if_due(limit);
            self.begin_pass();
            // After several passes without a merge, all edges are tried once more before the run ends.
            if n_idle_passes >= MOST_IDLE_PASSES {
                self.reset_failed_merges();
            }
            // A pass visits the vertices with the cheapest edges, about as many as merges remain, and merges each along
            // its edge unless an end was merged in this pass. The last merges go in the order of price, the others in
            // that of memory, which is faster.
            let is_last = self.merges_to(limit) as f64 <= LAST_SHARE * n_all as f64;
            let (candidates, most_price) = self.candidates(limit, n_idle_passes, is_last);
            let before = self.n_vertices;
            match is_last {
                true => self.visit(&candidates, most_price, limit),
                false => self.visit_in_stretches(&candidates, most_price, limit),
            }
            // The highest price of a pass with merges is what a vertex costs at that size.
            if self.n_vertices < before {
                let highest = candidates.iter().map(|candidate| candidate.price).fold(0.0, f32::max);
                self.pass_prices.push((self.n_vertices, highest));
                n_idle_passes = 0;
            } else if n_idle_passes >= MOST_IDLE_PASSES {
                return self.end_reason(limit);
            } else {
                n_idle_passes += 1;
            }
        }
        CollapseEnd::Reached
    }

    fn end_reason(&self, limit: Limit) -> CollapseEnd {
        match (&self.rules.constraints, self.was_turn_forbidden) {
            // The order ranks the reasons: constraints that the caller can change come first.
            _ if limit.price < f32::INFINITY => CollapseEnd::Reached,
            _ if self.was_ceiling_met => CollapseEnd::LosesShape,
            (Some(constraints), _) if constraints.has_more_than_plane() => CollapseEnd::Held,
            (_, true) => CollapseEnd::WouldTurn,
            (Some(_), _) => CollapseEnd::SmallestMirrored,
            _ => CollapseEnd::Smallest,
        }
    }

    pub(super) fn begin_pass(&mut self) {
        self.compact();
        let stale = self.renew_quadrics();
        self.pass += 1;
        self.price(&stale);
    }

    fn reset_failed_merges(&mut self) {
        self.nodes.iter_mut().for_each(|node| node.wait = 0.0);
        (self.was_turn_forbidden, self.was_ceiling_met) = (false, false);
    }

    fn candidates(&self, limit: Limit, n_idle_passes: i32, is_last: bool) -> (Vec<Candidate>, f32) {
        // Every vertex offers its cheapest edge, so there are more candidates than disjoint edges.
        let n_merges = self.merges_to(limit);
        let share = if is_last { LAST_VISITS_PER_MERGE } else { VISITS_PER_MERGE };
        let n = ((n_merges as f64 * share) as usize)
            .max(LEAST_VISITS.min(n_merges))
            .saturating_mul(VISIT_GROWTH.pow(n_idle_passes as u32));
        // A vertex whose cheaper edges failed counts by the price of its next edge.
        let price = |(cheapest, node): (&CheapestEdge, &CollapseVertex)| cheapest.price().max(node.wait);
        let priced = self.cheapest.par_iter().zip(&self.nodes).with_min_len(PARALLEL);
        let prices: Vec<f32> = priced.map(price).collect();
        // The threshold admits as many vertices as merges remain.
        let most_price = if n_idle_passes >= MOST_IDLE_PASSES { f32::MAX } else { nth_price(&prices, n) };
        let most_price = most_price.min(limit.price);
        let pulse = self.pulse.counting_if(false);
        let taken = indices_where(pulse, &prices, |_, price| *price <= most_price);
        let edge = |vertex: u32| self.cheapest[vertex as usize].edge();
        let candidate = |&vertex: &u32| Candidate { price: prices[vertex as usize], vertex, edge: edge(vertex) };
        let mut candidates = pulse.map(&taken, candidate);
        if is_last {
            candidates.sort_unstable_by(|x, y| x.price.total_cmp(&y.price).then(x.vertex.cmp(&y.vertex)));
        }
        (candidates, most_price)
    }

    fn price(&mut self, stale: &[u32]) {
        // Prices change only at vertices whose quadrics changed, and at their neighbours.
        let is_unknown = if self.cheapest.is_empty() { Vec::new() } else { self.mark_neighbourhood(stale) };
        let mut cheapest = std::mem::take(&mut self.cheapest);
        cheapest.resize(self.n_inner, CheapestEdge::NONE);
        let is_known = |v: usize| is_unknown.get(v).is_some_and(|unknown| !unknown) && self.nodes[v].corner != REMOVED;
        cheapest.iter_mut().enumerate().filter(|(v, _)| !is_known(*v)).for_each(|(_, edge)| *edge = CheapestEdge::NONE);
        // Each stretch of faces updates its own vertices, and returns the edges of others.
        let ends = stretch::stretch_ends(self);
        let firsts = std::iter::once(0).chain(ends.iter().map(|end| end.faces));
        let faces = firsts.zip(&ends).map(|(first, end)| first..end.faces);
        let stretches: Vec<_> = faces.zip(stretch::split_by_vertices(&ends, &mut cheapest)).collect();
        let price_stretch = |(faces, (first_vertex, cheapest)): (Range<usize>, (u32, &mut [CheapestEdge]))| {
            self.pulse.beat(0);
            let (is_unknown, others) = (&is_unknown[..], Vec::new());
            Isa::best().run(Pricing { collapse: self, faces, is_unknown, first_vertex, cheapest, others })
        };
        let others: Vec<_> = stretches.into_par_iter().map(price_stretch).collect();
        for (v, edge) in others.into_iter().flatten() {
            let cheapest = &mut cheapest[v as usize];
            *cheapest = edge.min(*cheapest);
        }
        self.cheapest = cheapest;
    }

    /// Marks these vertices and their neighbours; returns an empty list, which means all, if they are many.
    fn mark_neighbourhood(&self, vertices: &[u32]) -> Vec<bool> {
        if vertices.len() * 4 > self.n_inner {
            return Vec::new();
        }
        let mut is_near = vec![false; self.nodes.len()];
        for &v in vertices {
            is_near[v as usize] = true;
            self.neighbors(v).for_each(|w| is_near[w as usize] = true);
        }
        is_near
    }

    #[inline(always)]
    fn is_special_edge(&self, ends: [u32; 2]) -> bool {
        !self.is_special.is_empty() && ends.into_iter().any(|v| self.is_special[self.nodes[v as usize].id as usize])
    }

    /// Visits candidates in parallel, those first whose neighbours are all in one stretch.
    fn visit_in_stretches(&mut self, candidates: &[Candidate], most_price: f32, limit: Limit) {
        let ends = stretch::stretch_ends(self);
        if ends.len() == 1 || self.plane().is_some() || !self.rules.poses.is_empty() {
            return self.visit(candidates, most_price, limit);
        }
        // So many merges never go below the limit.
        let (sure, rest) = candidates.split_at(merges_to(limit, self.n_vertices, self.n_faces).min(candidates.len()));
        let Self { nodes, corners, ceilings, is_special, pass, n_link_tests, pulse, .. } = self;
        let stretches = stretch::split(&ends, nodes, corners).into_iter().zip(candidates_of_stretches(sure, &ends));
        let merge_stretch = |(stretch, candidates): (_, &[Candidate])| {
            let done = Merges { n_link_tests: *n_link_tests, ..Merges::default() };
            let (rules, end_rings) = (&mut Rules::default(), Default::default());
            let mut merger = Merger { stretch, rules, is_special, ceilings, pass: *pass, end_rings, done };
            Isa::best().run(Visits { merger: &mut merger, candidates, most_price, has_reached: &|_| false });
            pulse.beat(merger.done.merges.len());
            merger.done
        };
        let done: Vec<Merges> = stretches.collect::<Vec<_>>().into_par_iter().map(merge_stretch).collect();
        let deferred: Vec<Candidate> = done.iter().flat_map(|done| &done.deferred).chain(rest).copied().collect();
        done.into_iter().for_each(|done| self.record(done));
        self.visit(&deferred, most_price, limit);
    }

    /// Visits candidates in order, until the limit.
    fn visit(&mut self, candidates: &[Candidate], most_price: f32, limit: Limit) {
        for candidates in candidates.chunks(BETWEEN_BEATS) {
            let Self { n_vertices, n_faces, .. } = *self;
            let has_reached = |merger: &Merger| {
                let (n_merges, n_faces_removed) = (merger.done.merges.len(), merger.done.n_faces_removed);
                let plane = merger.rules.constraints.as_ref().and_then(|constraints| constraints.pins.plane());
                limit.is_met_by_size(whole_size(n_vertices - n_merges, n_faces - n_faces_removed, plane))
            };
            self.merge_with(|merger| {
                Isa::best().run(Visits { merger, candidates, most_price, has_reached: &has_reached });
            });
            self.pulse.beat(n_vertices - self.n_vertices);
        }
    }

    /// Lets a merger of the whole mesh work, and records its merges.
    pub(super) fn merge_with<T>(&mut self, work: impl FnOnce(&mut Merger) -> T) -> T {
        let Self { nodes, corners, n_inner, rules, ceilings, pass, n_link_tests, .. } = self;
        let stretch = stretch::whole(nodes, corners, *n_inner);
        let done = Merges { n_link_tests: *n_link_tests, ..Merges::default() };
        let end_rings = Default::default();
        let mut merger = Merger { stretch, rules, is_special: &[], ceilings, pass: *pass, end_rings, done };
        let result = work(&mut merger);
        let done = merger.done;
        self.record(done);
        result
    }

    fn record(&mut self, done: Merges) {
        self.n_vertices -= done.merges.len();
        self.n_faces -= done.n_faces_removed;
        self.n_link_tests = self.n_link_tests.max(done.n_link_tests);
        self.was_turn_forbidden |= done.was_turn_forbidden;
        self.was_ceiling_met |= done.was_ceiling_met;
        for (merge, ceiling) in done.merges {
            let [kept, removed] = [merge.kept, merge.removed].map(|v| v as usize);
            self.merged[removed] = merge.kept;
            if !self.is_special.is_empty() {
                self.is_special[kept] |= self.is_special[removed];
            }
            self.ceilings.get_mut(kept).into_iter().for_each(|of_kept| *of_kept = ceiling);
            self.history.iter_mut().for_each(|history| history.push(CollapseEvent::Merge(merge)));
        }
    }

}

fn candidates_of_stretches<'a>(
    mut candidates: &'a [Candidate],
    ends: &[StretchEnd],
) -> impl Iterator<Item = &'a [Candidate]> {
    ends.iter().map(move |end| {
        let n = candidates.partition_point(|candidate| (candidate.vertex as usize) < end.vertices);
        let of_stretch;
        (of_stretch, candidates) = candidates.split_at(n);
        of_stretch
    })
}

fn nth_price(prices: &[f32], n: usize) -> f32 {
    let mut finite: Vec<f32> = prices.iter().copied().filter(|price| *price < f32::INFINITY).collect();
    match finite.len() {
        0 => 0.0,
        n_finite => *finite.select_nth_unstable_by(n.clamp(1, n_finite) - 1, f32::total_cmp).1,
    }
}
