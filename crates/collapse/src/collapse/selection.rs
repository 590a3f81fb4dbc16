//! Which merges a pass may make: up to which price vertices are visited, and how far the surface may move.
//!
//! A vertex that was refused twice rests until it is merged into or loses a neighbour. So the cheapest edges, of which the
//! most can never be merged after many passes, do not keep the others from being tried.

use crate::collapse::lanes::VertexQuadric;
use crate::collapse::options::PassListener;
use crate::collapse::rings::{Rings, state};
use crate::collapse::team::Team;
use crate::collapse::threshold::{ANY, PriceRanks};
use crate::collapse::visit::Unit;

/// Vertices visited per merge that is left, for small and for large results.
const VISITS: [f32; 2] = [1.0, 1.4];

/// The part of all merges that is left to the last pass.
const LAST_PART: f32 = 0.01;

/// Most merges of the last pass per vertex that is left.
///
/// At .3 in place of .1 mean distances of 58 meshes are 2 % larger at .01 and as large at .05.
const LAST_SHARE: f32 = 0.1;

/// Merges below which a pass is the last.
const LAST_MERGES: usize = 32;

/// Vertices visited per merge in the last pass, most of them without success.
const LAST_VISITS: f32 = 3.5;

/// The guard's limit, squared, over the mean squared distance from planes at the pass's price.
///
/// 116 meshes at .05 and .01: at 10 mean distances are 2 and 3 % larger, the largest 2 and 0 %; at 24 mean distances are
/// 1 and 2 % smaller, the largest as large.
const GUARD: f32 = 16.0;

/// Largest price of a pass over that up to which as many vertices are as merges are left.
///
/// Without it, passes to half of a mesh with flat parts go on to dear merges while cheap ones wait.
const LARGEST_RATIO: f32 = 4.0;

/// Growth of the guard's limit where nothing is left to try below it.
const GIVING_WAY: f32 = 4.0;

/// A pass is slow if it merges less than one in this number of those that it wants to visit.
const SLOW: usize = 100;

/// Number of times that the guard gives way without a merge before the run ends.
const VAIN_PASSES: usize = 8;

/// A size to come down to, and what bounds the merges on the way.
#[derive(Clone, Copy)]
pub(crate) struct SizeGoal<'a> {
    pub unit: Unit,
    pub size: usize,
    /// Size after whose pass the run ends on its way; the goal itself for none.
    pub pause: usize,
    /// Largest error of a vertex, in the unit frame.
    pub max_error: f32,
    /// True if vertices may move.
    pub moves: bool,
    pub records_merges: bool,
    /// Called before each pass.
    pub listener: Option<PassListener<'a>>,
}

impl SizeGoal<'_> {
    /// Tells the listener which share is done; returns false if it ends the run.
    pub(crate) fn goes_on(&self, start: usize, size: usize) -> bool {
        let share = (start - size) as f32 / (start - self.size) as f32;
        self.listener.is_none_or(|listener| listener(share).is_continue())
    }
}

/// Limits of the merges of a pass.
#[derive(Clone, Copy)]
pub(crate) struct Selection {
    /// Bits of the price up to which vertices are visited.
    pub threshold: u32,
    /// Largest usual price of a merge: the threshold, or `LARGEST_RATIO` times the price of the last merge needed if less.
    pub price: f32,
    /// Mean squared distance from planes at that price.
    pub mean_square: f32,
    /// Largest error of a vertex whose star is not flat.
    pub guard: f32,
    /// Largest error of any vertex.
    pub max_error: f32,
    /// Most faces or vertices to remove.
    pub budget: usize,
    pub unit: Unit,
    /// True in the last pass: vertices are visited from the cheapest on, in one stretch.
    pub is_sorted: bool,
    /// Number of vertices to visit if few are refused.
    n_wanted: usize,
}

/// Chooses the merges of each pass, by those that the passes before made and refused.
pub(crate) struct MergeChooser<'a> {
    goal: SizeGoal<'a>,
    /// Size before the first pass.
    start: usize,
    /// Largest limit of the guard so far, which never falls.
    guard: f32,
    /// Limit at which all refused merges were last tried again.
    tried: f32,
    /// Slow passes in a row: the next one visits twice as many each time, as the cheapest are refused.
    n_slow: i32,
    /// Number of times that the guard gave way since the last merge.
    n_vain: usize,
}

impl<'a> MergeChooser<'a> {
    pub(crate) fn new(goal: SizeGoal<'a>, start: usize) -> Self {
        Self { goal, start, guard: 0.0, tried: 0.0, n_slow: 0, n_vain: 0 }
    }

    /// Returns false once nothing more gives way.
    pub(crate) fn has_hope(&self) -> bool {
        self.n_vain < VAIN_PASSES
    }

    /// Chooses the merges of a pass by the best price of each vertex; `n_left` faces or vertices have to go.
    pub(crate) fn choose(&mut self, best: &[u64], quadrics: &[VertexQuadric], n_left: usize, team: Team) -> Selection {
        let SizeGoal { unit, size, max_error, .. } = self.goal;
        // Most merges remove two faces.
        let n_merges = if unit == Unit::Face { n_left.div_ceil(2) } else { n_left };
        let is_near_end = n_left as f32 <= LAST_PART * (self.start - size) as f32;
        let is_last = is_near_end && n_merges as f32 <= LAST_SHARE * best.len() as f32 || n_merges <= LAST_MERGES;
        // From a fifth on, more visits cost less time than they cost distance.
        let large = ((size as f32 / self.start as f32 - 0.2) / 0.3).clamp(0.0, 1.0);
        let visits = if is_last { LAST_VISITS } else { VISITS[0] + large * (VISITS[1] - VISITS[0]) };
        let n_wanted = ((n_merges as f32 * visits) as usize).max(LAST_MERGES);
        let growth = 2f32.powi(self.n_slow);
        let grow = |n: usize| ((n as f32 * growth) as usize).min(best.len());

        let ranks = PriceRanks::new(best, team);
        let price_at = |n: usize| f32::from_bits(ranks.find_threshold(n));
        let n_candidates = ranks.n_candidates();
        let mut threshold = price_at(grow(n_wanted));
        let enough = price_at(n_merges.min(n_candidates));
        // Where fewer are left than are needed, all are tried.
        let is_short = n_candidates <= n_merges;
        if !is_last && !is_short {
            let enough = if self.n_slow == 0 { enough } else { price_at(grow(n_merges)) };
            threshold = threshold.min(LARGEST_RATIO * enough);
        }
        let price = threshold.min(LARGEST_RATIO * enough);
        let mean_area = quadrics.iter().map(|q| q.0[6]).sum::<f32>() / quadrics.len() as f32;
        // Half of the price per area: a merge's planes are those of two vertices.
        let mean_square = 0.5 * price / mean_area;
        // The few that are left may be dear.
        if !is_short || self.guard == 0.0 {
            self.guard = self.guard.max((GUARD * mean_square).sqrt());
        }
        let threshold = threshold.to_bits();
        let (guard, budget, is_sorted) = (self.guard, n_left, is_last);
        Selection { threshold, price, mean_square, guard, max_error, budget, unit, is_sorted, n_wanted }
    }

    /// Counts a pass; where nothing is left to try, the guard gives way, and all is tried again.
    pub(crate) fn count_pass(&mut self, selection: Selection, n_merges: usize, rings: &mut Rings) {
        let is_slow = n_merges * SLOW < selection.n_wanted;
        self.n_slow = if is_slow { self.n_slow + 1 } else { 0 };
        if n_merges > 0 {
            self.n_vain = 0;
        }
        if is_slow && selection.threshold >= ANY {
            let is_vain = self.tried >= selection.max_error;
            self.n_vain = if is_vain { VAIN_PASSES } else { self.n_vain + 1 };
            self.tried = self.guard;
            self.guard *= GIVING_WAY;
            rings.states.iter_mut().for_each(|state| *state &= !(state::REFUSED | state::RESTS));
        }
    }
}
