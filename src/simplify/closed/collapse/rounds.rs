//! The order of a collapse: rounds over the vertices as they lie in memory, at prices that rise from round to round.
//!
//! Every vertex knows what it costs to merge it with each of its neighbours, and with whom that costs least. A round visits the vertices
//! whose least price is among the lowest of all, half as many as merges are left to do and each once, so that it ends where the order
//! of the prices would. A merged vertex is priced at once, side by side with all of its neighbours, and they are told. No queue is
//! kept: who is among the lowest is found by a look at one number per vertex.

use crate::linalg::{Isa, Work};
use crate::simplify::limits::Limit;

use super::complex::{Collapse, End, NONE, merges_to};
use super::links::WIDTH;
use super::pair::{Node, prices_around};

/// An edge that may not go now is tried again at so many times its price. Results hardly depend on it: at 1.2 and 2.5
/// one of 64 differs (sixteen training meshes, four ratios).
const PATIENCE: f32 = 1.5;
/// Rounds in vain, one after the other, from which on prices rise by the square of what they rose by before, and all vertices have their
/// turn: where parts are so small that no edge of them may go, prices differ by tens of orders of magnitude, and each round tries
/// all those edges again.
const MOST_IN_VAIN: i32 = 8;
/// Merges that are left to do, for each vertex that a round visits. Sixteen training meshes, four ratios: at 1 the
/// largest distance is 5 % farther; at 4 the mean is 0.5 % nearer, for more rounds.
const MERGES_PER_VISIT: usize = 2;
/// Vertices whose prices are looked at together: one cache line of them. Results do not depend on it.
const CHUNK: usize = 16;
/// Vertices whose prices stand for all. Sixteen training meshes, four ratios: 256 or 4096 move the mean distance by
/// 0.4 %, as another order of the vertices does.
const SAMPLES: usize = 1024;
/// Vertices that are priced or visited between two beats: a few milliseconds.
const BETWEEN_BEATS: usize = 4096;
/// Samples below the price of a round, at least, so that their number is right within a quarter; where there would be
/// fewer, the prices of all vertices are looked at. At 4 or 64 the mean distance moves by 0.2 % (sixteen training
/// meshes).
const LEAST_SAMPLES: usize = 16;

/// Pricing the edges of some vertices, or of all, as work that is compiled for the instructions at hand.
struct PriceAll<'a, 'b>(&'a mut Collapse<'b>, Option<Vec<u32>>);

impl Work for PriceAll<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        match self.1 {
            None => self.0.price_all(0..self.0.n_inner as u32),
            Some(vertices) => self.0.price_all(vertices.into_iter()),
        }
    }
}

/// A round, as work that is compiled for the instructions at hand.
struct Round<'a, 'b> {
    collapse: &'a mut Collapse<'b>,
    limit: Limit,
    most: f32,
    at_most: usize,
}

impl Work for Round<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let most = self.collapse.choose_turn(self.most, self.at_most);
        self.collapse.visit_all(self.limit, most);
    }
}

impl Collapse<'_> {
    /// Collapses the cheapest edges until the limit or until none may go. From so many times the limit on every price is that of
    /// the present surface.
    pub fn run(&mut self, limit: Limit, last_stretch: f64) -> End {
        self.hold_hubs();
        let stretch = limit.times(last_stretch);
        if self.merges_to(stretch) > 0 || !self.is_last_stretch {
            self.is_last_stretch = false;
            self.run_to(stretch);
            self.begin_last_stretch();
        }
        if self.plane().is_some() { self.run_half(limit) } else { self.run_to(limit) }
    }

    /// Collapses down to the limit or until no edge may go.
    pub(super) fn run_to(&mut self, limit: Limit) -> End {
        self.price();
        self.turn_forbidden = false;
        let (mut most, mut last_merge, mut n_in_vain) = (0.0f32, 0.0f32, 0);
        while !self.reached(limit) {
            self.keep_copy(limit);
            let before = self.n_vertices;
            let to_do = self.merges_to(limit);
            most = self.leap(price_of_round(to_do, most, [&*self]), n_in_vain).min(limit.price);
            if most == f32::INFINITY || n_in_vain > 0 && self.all_were_tried(most, last_merge) {
                return match (&self.constraints, self.turn_forbidden) {
                    _ if self.ceiling_met => End::LosesShape,
                    (Some(constraints), _) if constraints.hold_more_than_plane() => End::Held,
                    (_, true) => End::WouldTurn,
                    (Some(_), _) => End::SmallestMirrored,
                    _ => End::Smallest,
                };
            }
            self.round(limit, most, if n_in_vain < MOST_IN_VAIN { to_do } else { usize::MAX });
            n_in_vain = if self.n_vertices == before { n_in_vain + 1 } else { 0 };
            if n_in_vain > 0 && most == limit.price {
                return End::Reached;
            }
            if n_in_vain == 0 {
                last_merge = most.max(f32::MIN_POSITIVE);
                self.paid.push((self.n_vertices, most));
                self.turn_forbidden = false;
            }
        }
        End::Reached
    }

    /// The merges without which this limit is not reached. One along a boundary takes one face away, not two: as many are of that
    /// kind as the boundary has of the vertices.
    pub fn merges_to(&self, limit: Limit) -> usize {
        let (n_vertices, n_faces) = self.size();
        let least = merges_to(limit, n_vertices, n_faces);
        let n_boundary: usize = self.nodes[self.n_inner..].iter().map(|ghost| ghost.ring.len()).sum();
        if n_boundary == 0 || self.plane().is_some() || n_faces <= limit.faces {
            return least;
        }
        let share = (n_boundary as f64 / n_vertices.max(1) as f64).min(1.0);
        least.max(((n_faces - limit.faces) as f64 / (2.0 - share)) as usize)
    }

    /// Whether rounds up to `most` have tried every edge since the last merge, which was in a round up to `last_merge`: a vertex
    /// that has tried all of its edges in vain begins anew at [`PATIENCE`] times the price.
    fn all_were_tried(&self, most: f32, last_merge: f32) -> bool {
        /// A vertex that has tried its edges in vain waits until the price is [`PATIENCE`] times as high; after twice
        /// that every edge was tried.
        const TWICE: f32 = PATIENCE * PATIENCE;
        most > last_merge * TWICE && most > self.highest() * TWICE
    }

    /// The price of a round after so many in vain: that of the next vertices, or one much higher, but none that no edge has.
    fn leap(&self, most: f32, n_in_vain: i32) -> f32 {
        if n_in_vain < MOST_IN_VAIN {
            return most;
        }
        let rise = PATIENCE.powi(1 << (n_in_vain - MOST_IN_VAIN).min(8));
        most.max((most * rise).min(self.highest()))
    }

    /// The highest price of an edge that may go.
    fn highest(&self) -> f32 {
        let listed = self.living().map(|v| self.nodes[v as usize].ring).filter(|ring| !ring.is_unlisted());
        let blocks = listed.flat_map(|ring| ring.blocks());
        let prices = blocks.flat_map(|block| self.links.prices(block)).copied();
        prices.filter(|price| *price < f32::INFINITY).fold(0.0, f32::max)
    }

    /// Prices the edges that may go and have no price yet.
    pub(super) fn price(&mut self) {
        let unpriced = self.unpriced.replace(Vec::new());
        Isa::best().run(PriceAll(self, unpriced));
    }

    /// Visits the vertices whose least price is at most `most`, or the cheapest `at_most` of them, until the limit.
    pub(super) fn round(&mut self, limit: Limit, most: f32, at_most: usize) {
        Isa::best().run(Round { collapse: self, limit, most, at_most });
    }

    /// How many vertices have a price of at most `most`.
    pub(super) fn n_up_to(&self, most: f32) -> usize {
        self.least.iter().filter(|price| **price <= most).count()
    }

    #[inline(always)]
    fn price_all(&mut self, vertices: impl Iterator<Item = u32>) {
        for (n_before, u) in vertices.enumerate() {
            if n_before % BETWEEN_BEATS == 0 {
                self.pulse.beat(0);
            }
            if self.merged[u as usize] == u && !self.is_frozen(u) {
                self.price_around(u);
            }
        }
    }

    /// Chooses the vertices whose turn it is; returns up to which price.
    #[inline(always)]
    fn choose_turn(&mut self, most: f32, at_most: usize) -> f32 {
        let (turn, least) = (&mut self.turn, &self.least);
        turn.clear();
        for (prices, first) in least.chunks(CHUNK).zip((0..).step_by(CHUNK)) {
            if prices.iter().fold(false, |any, price| any | (*price <= most)) {
                turn.extend((first..).zip(prices).filter(|(_, price)| **price <= most).map(|(u, _)| u));
            }
        }
        if turn.len() <= at_most {
            return most;
        }
        let price = |u: &u32| least[*u as usize];
        turn.select_nth_unstable_by(at_most, |u, v| price(u).total_cmp(&price(v)).then(u.cmp(v)));
        turn.truncate(at_most);
        turn.sort_unstable();
        turn.iter().map(price).fold(0.0, f32::max)
    }

    #[inline(always)]
    fn visit_all(&mut self, limit: Limit, most: f32) {
        let turn = std::mem::take(&mut self.turn);
        for turn in turn.chunks(BETWEEN_BEATS) {
            let n_before = self.n_vertices;
            for &u in turn {
                self.visit(u, most);
                if self.reached(limit) {
                    break;
                }
            }
            self.pulse.beat(n_before - self.n_vertices);
            if self.reached(limit) {
                break;
            }
        }
        self.turn = turn;
    }

    /// Merges `u` with the neighbour that costs least, if one at this price at most may be merged with it.
    #[inline(always)]
    fn visit(&mut self, u: u32, most: f32) {
        while self.least[u as usize] <= most {
            let v = self.nodes[u as usize].partner;
            if self.try_merge(u, v) {
                return;
            }
            self.choose_next(u, v, most);
        }
    }

    /// Merges `v` into `u` if that may be done, and prices what has changed.
    #[inline(always)]
    pub(super) fn try_merge(&mut self, u: u32, v: u32) -> bool {
        let done = self.try_collapse(u, v);
        if done {
            self.least[v as usize] = f32::INFINITY;
            self.price_around(u);
            self.tell_neighbors(u, v);
            if self.is_last_stretch {
                self.price_neighbors(u);
            }
        }
        done
    }

    /// Sums and prices the neighbours of a merged vertex anew.
    fn price_neighbors(&mut self, u: u32) {
        let neighbors: Vec<u32> = self.ring(u).filter(|&w| !self.is_ghost(w) && !self.is_frozen(w)).collect();
        neighbors.iter().for_each(|&w| self.renew(w));
        for w in neighbors {
            self.price_around(w);
            self.tell_neighbors(w, u);
        }
    }

    /// Prices `u` with all its neighbours, and chooses the one that costs least.
    #[inline(always)]
    fn price_around(&mut self, u: u32) {
        let ring = self.nodes[u as usize].ring;
        for (i, block) in ring.blocks().enumerate() {
            let ends = *self.links.block(block);
            let n = ring.len() - i * WIDTH;
            let mut prices = if self.is_plain() {
                let node = |i: usize| &self.nodes[if i < n { ends[i] } else { u } as usize];
                prices_around(&self.nodes[u as usize], std::array::from_fn(node))
            } else {
                ends.map(|w| if self.is_ghost(w) { f32::INFINITY } else { self.constrained_price(u, w) })
            };
            for (price, w) in prices.iter_mut().zip(ends) {
                let may_go = !self.is_ghost(w) && !self.is_frozen(w) && *price < f32::INFINITY;
                *price = if may_go { *price } else { f32::INFINITY };
            }
            *self.links.prices_mut(block) = prices;
        }
        self.choose(u);
    }

    /// Chooses the neighbour that it costs least to merge `u` with.
    #[inline(always)]
    fn choose(&mut self, u: u32) {
        (self.least[u as usize], self.nodes[u as usize].partner) = self.links.cheapest(self.nodes[u as usize].ring);
    }

    /// Tells the neighbours of `u`, into which `gone` was merged, what it costs to merge them with it.
    #[inline(always)]
    fn tell_neighbors(&mut self, u: u32, gone: u32) {
        for block in self.nodes[u as usize].ring.blocks() {
            let (ends, prices) = (*self.links.block(block), *self.links.prices(block));
            for (w, price) in ends.into_iter().zip(prices) {
                // Behind the last neighbour stands what is no vertex either.
                if self.is_ghost(w) || self.is_frozen(w) {
                    continue;
                }
                let Node { partner, ring, .. } = self.nodes[w as usize];
                self.links.set_price(ring, u, price);
                if price <= self.least[w as usize] {
                    (self.least[w as usize], self.nodes[w as usize].partner) = (price, u);
                } else if partner == u || partner == gone {
                    self.choose(w);
                }
            }
        }
    }

    /// Chooses the neighbour that is to be tried after `tried`: the next one by its price, and after the last the first one
    /// again, at more than `most`.
    #[inline(never)]
    fn choose_next(&mut self, u: u32, tried: u32, most: f32) {
        let blocks = self.nodes[u as usize].ring.blocks();
        let edges = blocks.flat_map(|block| self.links.prices(block).iter().zip(self.links.block(block)));
        let mut edges: Vec<(f32, u32)> = edges.map(|(&price, &w)| (price, w)).collect();
        edges.retain(|(price, _)| *price < f32::INFINITY);
        edges.sort_unstable_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
        let after = edges.iter().position(|&(_, w)| w == tried).map_or(0, |at| at + 1);
        let level = self.least[u as usize];
        let next = match (edges.get(after), edges.first()) {
            (Some(&(price, w)), _) => (price.max(level), w),
            (None, Some(&(_, w))) => (level.max(most).max(f32::MIN_POSITIVE) * PATIENCE, w),
            (None, None) => (f32::INFINITY, NONE),
        };
        (self.least[u as usize], self.nodes[u as usize].partner) = next;
    }
}

/// The price up to which a round takes vertices where so many merges are left to do and the last round went up to `last`: about
/// half as many vertices have it at most, towards the end as many.
pub(super) fn price_of_round<'a>(
    to_do: usize,
    last: f32,
    parts: impl IntoIterator<Item = &'a Collapse<'a>> + Clone,
) -> f32 {
    let n_all: usize = parts.clone().into_iter().map(|part| part.least.len()).sum();
    let step = (n_all / SAMPLES).max(1);
    let up_to = |most: f32, step: usize| {
        let mut prices: Vec<f32> = Vec::new();
        for part in parts.clone() {
            prices.extend(part.least.iter().step_by(step).filter(|price| **price <= most));
        }
        prices
    };
    let nth = |n: usize, mut prices: Vec<f32>| match prices.len() {
        0 => f32::INFINITY,
        n_prices => *prices.select_nth_unstable_by(n.clamp(1, n_prices) - 1, f32::total_cmp).1,
    };
    let of_samples = to_do / MERGES_PER_VISIT / step;
    if of_samples >= LEAST_SAMPLES {
        return nth(of_samples, up_to(f32::MAX, step));
    }
    // Towards the end the next price is little more than the last one.
    let near = up_to(last * PATIENCE, 1);
    nth(to_do, if near.len() < to_do { up_to(f32::MAX, 1) } else { near })
}
