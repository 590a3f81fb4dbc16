//! Passes of a collapse: merges at the cheapest prices of the present surface.

use crate::linalg::{Isa, Work};
use crate::mesh::pulse::PARALLEL;
use crate::mesh::thread_ranges::indices_where;
use crate::parallel;
use crate::simplify::limits::Limit;

use super::cheapest_edge::CheapestEdge;
use super::pair::{LastChange, WIDTH, prices};
use super::state::{Collapse, CollapseEnd, REMOVED};
use super::stretch::Stretch;

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
/// Consecutive passes without a merge after which edges are tried that failed before.
const MOST_IDLE_PASSES: i32 = 3;
/// Share of a vertex's `wait` below which its edges have failed already.
const WAIT_SLACK: f32 = 0.999;
/// Classes of price that a pass of a recorded collapse visits one after the other.
// Within a class the order is that of memory, which is faster than that of price and nearly as good.
const PRICE_CLASSES: usize = 6;
const PRICE_SAMPLES: usize = 4096;
/// Number of vertices up to which a pass makes a single merge, the cheapest.
// Passes visit several vertices per merge, so at few vertices also those that must stay: a cube subdivided six times loses
// a corner, 3.9 % of its diagonal.
const FEW_VERTICES: usize = 16;
const BATCH: usize = 128;
const BETWEEN_BEATS: usize = 4096;

#[derive(Clone, Copy)]
struct Candidate {
    price: f32,
    vertex: u32,
    edge: u32,
}

struct Pricing<'a, 'b> {
    collapse: &'a Collapse<'b>,
    /// Faces to price, and cheapest edges; an edge belongs to the face with the smaller of its opposite corners.
    stretch: Stretch<'a, CheapestEdge>,
    /// Marks vertices without a known cheapest edge; empty to mark all.
    is_unknown: &'a [bool],
    /// Edges of vertices outside of the stretch.
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
        for (first, [a, b, c], across) in self.collapse.corners.faces_in(self.stretch.faces.clone()) {
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
        let price = if is_special { self.collapse.constrained_price(edge.ends[0], edge.ends[1]) } else { plain };
        let priced = CheapestEdge::new(price, edge.number);
        for v in edge.ends {
            match self.stretch.row_mut(v) {
                Some(cheapest) => *cheapest = priced.min(*cheapest),
                None => self.others.push((v, priced)),
            }
        }
    }
}

struct Visits<'a, 'b> {
    collapse: &'a mut Collapse<'b>,
    candidates: &'a [Candidate],
    most_price: f32,
    limit: Limit,
}

impl Work for Visits<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for candidates in self.candidates.chunks(BETWEEN_BEATS) {
            let n_before = self.collapse.n_vertices;
            for candidate in candidates {
                if self.collapse.has_reached(self.limit) {
                    break;
                }
                self.collapse.visit(candidate, self.most_price);
            }
            self.collapse.pulse.beat(n_before - self.collapse.n_vertices);
        }
    }
}

impl Collapse<'_> {
    /// Collapses the cheapest edges until the limit, or until no merge is possible.
    pub fn run(&mut self, limit: Limit) -> CollapseEnd {
        let n_all = self.merges_to(limit);
        let mut n_idle_passes = 0;
        while !self.has_reached(limit) {
            // The copy for dropped components must be made before the pass that goes below its size.
            self.make_copy_if_due(limit);
            self.begin_pass();
            // After several passes without a merge, failed edges are tried once more before the run ends, if something changed.
            if n_idle_passes >= MOST_IDLE_PASSES {
                self.reset_failed_merges();
            }
            // A pass visits the vertices with the cheapest edges, about as many as merges remain, and merges each along
            // its edge unless an end was merged in this pass. The last merges go in the order of price, the others in
            // that of memory, which is faster.
            let is_last = self.has_few_vertices() || self.merges_to(limit) as f64 <= LAST_SHARE * n_all as f64;
            let (candidates, most_price) = self.candidates(limit, n_idle_passes, is_last);
            let before = self.n_vertices;
            let limit = if self.has_few_vertices() { self.limit_of_one_merge(limit) } else { limit };
            Isa::best().run(Visits { collapse: self, candidates: &candidates, most_price, limit });
            // The highest price of a pass with merges is what a vertex costs at that size.
            if self.n_vertices < before {
                let highest = candidates.iter().map(|candidate| candidate.price).fold(0.0, f32::max);
                self.pass_prices.push((self.n_vertices, highest));
                n_idle_passes = 0;
            } else if n_idle_passes >= MOST_IDLE_PASSES {
                return self.end_reason(limit);
            } else {
                // With nothing left to visit, further passes would be idle, too.
                n_idle_passes = if candidates.is_empty() { MOST_IDLE_PASSES } else { n_idle_passes + 1 };
            }
        }
        CollapseEnd::Reached
    }

    fn has_few_vertices(&self) -> bool {
        self.n_vertices <= FEW_VERTICES
    }

    fn limit_of_one_merge(&self, limit: Limit) -> Limit {
        Limit { vertices: self.n_vertices - 1, faces: usize::MAX, ..limit }
    }

    fn end_reason(&self, limit: Limit) -> CollapseEnd {
        match (&self.constraints, self.was_turn_forbidden) {
            // The order ranks the reasons: constraints that the caller can change come first.
            _ if limit.price < f32::INFINITY => CollapseEnd::Reached,
            _ if self.was_ceiling_met => CollapseEnd::LosesShape,
            (Some(constraints), _) if constraints.is_binding() => CollapseEnd::Held,
            (_, true) => CollapseEnd::WouldTurn,
            _ => CollapseEnd::Smallest,
        }
    }

    pub(super) fn begin_pass(&mut self) {
        self.compact();
        let stale = self.renew_quadrics();
        self.pass += 1;
        self.price(&stale);
    }

    fn candidates(&self, limit: Limit, n_idle_passes: i32, is_last: bool) -> (Vec<Candidate>, f32) {
        // Every vertex offers its cheapest edge, so there are more candidates than disjoint edges.
        let most = if self.has_few_vertices() { 1 } else { self.most_merges_of_pass() };
        let n_merges = self.merges_to(limit).min(most);
        let share = if self.has_few_vertices() {
            1.0
        } else if is_last {
            LAST_VISITS_PER_MERGE
        } else {
            VISITS_PER_MERGE
        };
        let n = ((n_merges as f64 * share) as usize)
            .max(LEAST_VISITS.min(n_merges))
            .saturating_mul(VISIT_GROWTH.pow(n_idle_passes as u32));
        // A vertex whose cheaper edges failed counts by the price of its next edge.
        let price = |v: usize| self.cheapest[v].price().max(self.nodes[v].wait);
        let prices: Vec<f32> = parallel::map(self.cheapest.len(), PARALLEL, price);
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
        } else if self.recording.is_some() {
            candidates = sort_by_price_class(&candidates);
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
        // Minima commute, so the result does not depend on the stretches.
        let price_stretch = |stretch| {
            self.pulse.beat(0);
            Isa::best().run(Pricing { collapse: self, stretch, is_unknown: &is_unknown, others: Vec::new() })
        };
        let others = parallel::each(self.split_into_stretches(&mut cheapest), price_stretch);
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
        !self.is_special.is_empty() && self.ids(ends).into_iter().any(|id| self.is_special[id as usize])
    }

    /// Merges a vertex along its cheapest edge, or else along the next that costs at most `most_price`.
    #[inline(always)]
    fn visit(&mut self, &Candidate { vertex, edge, .. }: &Candidate, most_price: f32) {
        if self.was_merged(vertex) {
            return;
        }
        let is_first = self.nodes[vertex as usize].wait == 0.0;
        if is_first {
            self.begin_failures(vertex);
        }
        let is_taken = || self.corners.edge(edge).into_iter().any(|v| self.was_merged(v));
        // If an end was merged in this pass, the price is stale: the vertex waits for the next pass.
        if is_first && (is_taken() || self.try_merge(vertex, edge)) {
            return;
        }
        self.try_others(vertex, is_first.then_some(edge), most_price);
    }

    #[inline(always)]
    fn was_merged(&self, v: u32) -> bool {
        self.nodes.get(v as usize).is_none_or(|node| node.changed == LastChange::from_merge(self.pass))
    }

    #[inline(never)]
    fn try_others(&mut self, v: u32, tried: Option<u32>, most_price: f32) {
        // Cheaper edges already failed, and nothing changed around them since.
        let least = WAIT_SLACK * self.nodes[v as usize].wait;
        let edges = self.edges_at(v);
        let others = edges.into_iter().filter(|&(price, edge)| price >= least && Some(edge) != tried);
        let mut next = f32::INFINITY;
        for (price, edge) in others {
            if price > most_price {
                next = price;
                break;
            }
            if !self.corners.edge(edge).into_iter().any(|w| self.was_merged(w)) && self.try_merge(v, edge) {
                return;
            }
        }
        // A change nearby may have made the failed edges possible.
        let node = &mut self.nodes[v as usize];
        node.wait = if node.changed.is_in(self.pass) { 0.0 } else { next };
        if node.wait == f32::INFINITY {
            self.end_failures(v);
        }
    }

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

/// Sorts candidates by classes of price; within a class, the order stays.
fn sort_by_price_class(candidates: &[Candidate]) -> Vec<Candidate> {
    let step = candidates.len().div_ceil(PRICE_SAMPLES).max(1);
    let mut sample: Vec<f32> = candidates.iter().step_by(step).map(|candidate| candidate.price).collect();
    sample.sort_unstable_by(f32::total_cmp);
    let bounds: [f32; PRICE_CLASSES - 1] =
        std::array::from_fn(|i| sample.get(sample.len() * (i + 1) / PRICE_CLASSES).copied().unwrap_or_default());
    let class = |candidate: &Candidate| bounds.iter().filter(|bound| candidate.price > **bound).count();
    let mut classes: [Vec<Candidate>; PRICE_CLASSES] = Default::default();
    candidates.iter().for_each(|candidate| classes[class(candidate)].push(*candidate));
    classes.concat()
}

fn nth_price(prices: &[f32], n: usize) -> f32 {
    let mut finite: Vec<f32> = prices.iter().copied().filter(|price| *price < f32::INFINITY).collect();
    match finite.len() {
        0 => 0.0,
        n_finite => *finite.select_nth_unstable_by(n.clamp(1, n_finite) - 1, f32::total_cmp).1,
    }
}
