//! Passes: quadrics, prices, threshold, merges and new rings, until the mesh has its size.
//!
//! All merges of a pass go by the quadrics and prices of its beginning, and a vertex is in one merge at most. Early passes
//! merge roughly half of the rest; the last merges from the cheapest edge on, to the exact size.

use crate::collapse::lanes::{VertexQuadric, dispatch};
use crate::collapse::merges::PassMerge;
use crate::collapse::options::PassListener;
use crate::collapse::price::{PriceEdges, PriceTerms};
use crate::collapse::quadric::SumQuadrics;
use crate::collapse::rebuild::rebuild;
use crate::collapse::rings::{Rings, state};
use crate::collapse::rounds::{PassMesh, Selection, merge_in_rounds};
use crate::collapse::sides::SideArrays;
use crate::collapse::team::{STRETCH, Team};
use crate::collapse::threshold::{ANY, PriceRanks};
use crate::collapse::visit::Unit;

/// Vertices visited per merge that is left, for small and for large results.
const VISITS: [f32; 2] = [1.0, 1.4];

/// The part of all merges that is left to the last pass.
const LAST_PART: f32 = 0.01;

/// Most merges of the last pass per vertex that is left; with more, a strong reduction ends in merges of any price.
const LAST_SHARE: f32 = 0.1;

/// Merges below which a pass is the last.
const LAST_MERGES: usize = 32;

/// Vertices visited per merge in the last pass, most of them without success.
const LAST_VISITS: f32 = 3.5;

/// The guard's limit, squared, over the mean squared distance from planes at the threshold.
///
/// 116 meshes at .05 and .01: at 10 mean distances are 2 and 3 % larger, the largest 2 and 0 %; at 24 mean distances are
/// 1 and 2 % smaller, the largest as large.
const GUARD: f32 = 16.0;

/// Largest price of a pass over that up to which as many vertices are as merges are left.
///
/// Without it, passes to half of a mesh with flat parts go on to dear merges while cheap ones wait.
const LARGEST_PRICE: f32 = 4.0;

/// Limits of the guard, squared, from which on a sample of the fit is of another part of the surface.
const FARTHEST: f32 = 8.0;

/// Growth of the guard's limit each time that no merge is left to try.
const GIVING_WAY: f32 = 4.0;

/// A pass is slow if it merges less than one in this number of those that it wants to visit.
const SLOW: usize = 100;

/// Passes without a merge until no more is hoped for.
const VAIN_PASSES: usize = 8;

const MOST_PASSES: usize = 200;

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
    // Tells the listener which share is done.
    fn goes_on(&self, start: usize, size: usize) -> bool {
        let share = (start - size) as f32 / (start - self.size) as f32;
        self.listener.is_none_or(|listener| listener(share).is_continue())
    }
}

/// The mesh after some passes.
#[derive(Clone)]
pub(crate) struct Collapsed {
    pub rings: Rings,
    /// For each pass the numbers of its vertices in the next mesh.
    pub numbers: Vec<Vec<u32>>,
    /// For each vertex of the rings one of the first mesh's that became it; where vertices do not move, it is there.
    pub origins: Vec<u32>,
    /// Squared distance from which on a sample is of another part of the surface.
    pub farthest: f32,
    /// For each pass that merged, the number of vertices left and the price up to which it merged.
    pub pass_prices: Vec<(usize, f32)>,
    /// For each such pass, the largest error of a vertex after it, in the unit frame.
    pub pass_errors: Vec<f32>,
    /// For each pass its merges, if they are recorded.
    pub merges: Vec<Vec<PassMerge>>,
    pub is_reached: bool,
}

impl Collapsed {
    /// Wraps the mesh before the first pass.
    pub(crate) fn new(rings: Rings) -> Self {
        let origins = (0..rings.vertices.len() as u32).collect();
        let (numbers, merges, pass_prices, pass_errors) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { rings, numbers, origins, farthest: f32::INFINITY, pass_prices, pass_errors, merges, is_reached: false }
    }
}

/// What is kept from pass to pass.
#[derive(Default)]
struct PassArrays {
    quadrics: Vec<VertexQuadric>,
    best: Vec<u64>,
    losses: Vec<f32>,
    room: Rings,
}

/// Merges until the goal is reached, or no merge is left; `sides` follow.
pub(crate) fn run_passes(collapsed: &mut Collapsed, goal: SizeGoal, mut sides: Option<&mut SideArrays>, team: Team) {
    let Collapsed { rings, numbers, origins, farthest, pass_prices, pass_errors, merges, is_reached } = collapsed;
    let start = measure_size(rings, goal.unit);
    let mut size = start;
    let mut arrays = PassArrays::default();
    let most_passes = numbers.len() + MOST_PASSES;
    let mut refusals = Refusals::default();
    while size > goal.size.max(goal.pause)
        && refusals.n_vain < VAIN_PASSES
        && numbers.len() < most_passes
        && goal.goes_on(start, size)
    {
        if let Some(sides) = &mut sides {
            sides.prepare_pass(rings, &mut arrays.losses);
        }
        price_all(rings, &mut arrays, goal.moves, team);
        let (mut selection, n_wanted) = select(&arrays, size - goal.size, start, goal, refusals.n_slow, team);
        *farthest = FARTHEST * selection.guard * selection.guard / GUARD;
        selection.guard = refusals.raise_guard(selection.guard);

        let before = goal.records_merges.then(|| rings.vertices.clone());
        let terms = PriceTerms { moves: goal.moves, losses: &arrays.losses, quadrics: &arrays.quadrics };
        let best = &mut arrays.best;
        let mesh = PassMesh { rings: &mut *rings, terms, best, selection, records_merges: goal.records_merges, team };
        let mut tally = merge_in_rounds(mesh, numbers.len());
        if let Some(before) = before {
            merges.push(tally.take_merges(origins, &before));
        }
        team.heartbeat.beat(tally.n_merges);
        size -= tally.count_spent(goal.unit).min(size);
        let price = f32::from_bits(selection.threshold) / mean_importance(&arrays.quadrics);
        refusals.follow(selection, tally.n_merges, n_wanted, rings);
        let (room, n_faces) = (std::mem::take(&mut arrays.room), rings.n_faces - tally.n_faces);
        let (next, of_next) = rebuild(rings, &arrays.best, room, n_faces, team);
        let mut states = rings.states.iter();
        origins.retain(|_| states.next().is_some_and(|state| state & state::GONE == 0));
        if let Some(sides) = &mut sides {
            sides.follow(rings, &next, &of_next);
        }
        // The arrays of a large mesh's first pass are too large to keep.
        if numbers.is_empty() && rings.vertices.len() > STRETCH {
            arrays.quadrics = Vec::new();
            arrays.best = Vec::new();
        } else {
            arrays.room = std::mem::take(rings);
        }
        *rings = next;
        numbers.push(of_next);
        if tally.n_merges > 0 {
            pass_prices.push((rings.vertices.len(), price));
            pass_errors.push(largest_error(rings));
        }
    }
    *is_reached = size <= goal.size;
}

/// What refusals change for the next passes. A refused vertex waits until its ring changes.
#[derive(Default)]
struct Refusals {
    /// Largest limit of the guard so far, which never falls.
    guard: f32,
    /// Slow passes in a row: the next one visits twice as many each time, as the cheapest are refused.
    n_slow: i32,
    /// Passes in a row without a merge.
    n_vain: usize,
}

impl Refusals {
    // Returns the limit of the guard in the next pass.
    fn raise_guard(&mut self, guard: f32) -> f32 {
        self.guard = self.guard.max(guard);
        self.guard
    }

    // Counts a pass; where no merge is left to try, the guard gives way, and all are tried again.
    fn follow(&mut self, selection: Selection, n_merges: usize, n_wanted: usize, rings: &mut Rings) {
        self.n_slow = if n_merges * SLOW < n_wanted { self.n_slow + 1 } else { 0 };
        self.n_vain = if n_merges == 0 { self.n_vain + 1 } else { 0 };
        if n_merges == 0 && selection.threshold == ANY {
            // Where the guard is not what refuses, nothing else gives way.
            self.n_vain += usize::from(self.guard >= selection.max_error) * VAIN_PASSES;
            self.guard *= GIVING_WAY;
            rings.states.iter_mut().for_each(|state| *state &= !(state::REFUSED | state::RESTS));
        }
    }
}

// The mean factor on the quadrics, by area.
fn mean_importance(quadrics: &[VertexQuadric]) -> f32 {
    let add = |[weighed, whole]: [f32; 2], q: &VertexQuadric| {
        let importance = q.importance();
        [weighed + q.0[6], whole + q.0[6] / importance.max(1e-3)]
    };
    let [weighed, whole] = quadrics.iter().fold([0.0; 2], add);
    if whole > 0.0 { weighed / whole } else { 1.0 }
}

/// Returns the largest error of a vertex, in the unit frame.
pub(crate) fn largest_error(rings: &Rings) -> f32 {
    rings.errors.iter().copied().fold(0.0, f32::max)
}

/// Counts the faces or the vertices of a mesh.
pub(crate) fn measure_size(rings: &Rings, unit: Unit) -> usize {
    match unit {
        Unit::Face => rings.n_faces,
        Unit::Vertex => rings.states.iter().filter(|&state| state & state::GONE == 0).count(),
    }
}

fn price_all(rings: &Rings, arrays: &mut PassArrays, moves: bool, team: Team) {
    let n = rings.vertices.len();
    arrays.quadrics.resize(n, VertexQuadric::default());
    arrays.best.resize(n, 0);
    let pieces = arrays.quadrics.chunks_mut(STRETCH).enumerate().collect();
    team.run(pieces, |(i, out)| dispatch(SumQuadrics { rings, first: i * STRETCH, out }));
    let terms = PriceTerms { moves, losses: &arrays.losses, quadrics: &arrays.quadrics };
    let mut elsewhere = vec![Vec::new(); n.div_ceil(STRETCH)];
    let pieces = arrays.best.chunks_mut(STRETCH).zip(&mut elsewhere).enumerate().collect();
    team.run(pieces, |(i, (best, elsewhere))| {
        dispatch(PriceEdges { rings, terms, first: i * STRETCH, best, elsewhere });
    });
    for (v, packed) in elsewhere.into_iter().flatten() {
        let best = &mut arrays.best[v as usize];
        *best = (*best).min(packed);
    }
}

// The merges of this pass, and how many vertices it wants to visit.
fn select(
    arrays: &PassArrays,
    n_left: usize,
    start: usize,
    goal: SizeGoal,
    n_slow: i32,
    team: Team,
) -> (Selection, usize) {
    let SizeGoal { unit, max_error, .. } = goal;
    let n_vertices = arrays.best.len();
    // Most merges remove two faces.
    let n_merges = if unit == Unit::Face { n_left.div_ceil(2) } else { n_left };
    let is_near_end = n_left as f32 <= LAST_PART * (start - goal.size) as f32;
    let is_last = is_near_end && n_merges as f32 <= LAST_SHARE * n_vertices as f32 || n_merges <= LAST_MERGES;
    let ratio = goal.size as f32 / start as f32;
    // From a fifth on, more visits cost less time than they cost distance.
    let large = ((ratio - 0.2) / 0.3).clamp(0.0, 1.0);
    let visits = if is_last { LAST_VISITS } else { VISITS[0] + large * (VISITS[1] - VISITS[0]) };
    let visits = visits * 2f32.powi(n_slow);
    let n_wanted = ((n_merges as f32 * visits) as usize).max(LAST_MERGES).min(n_vertices);
    let ranks = PriceRanks::new(&arrays.best, team);
    let n_candidates = ranks.n_candidates();
    let mut threshold = ranks.find_threshold(n_wanted);
    let enough = f32::from_bits(ranks.find_threshold(n_merges.min(n_candidates)));
    let largest_price = f32::from_bits(threshold).min(LARGEST_PRICE * enough);
    // Where fewer are left than are needed, all are tried, and the guard alone chooses.
    if !is_last && n_merges < n_candidates {
        threshold = threshold.min(largest_price.to_bits());
    }
    let areas: f32 = arrays.quadrics.iter().map(|q| q.0[6]).sum();
    let mean_area = areas / n_vertices as f32;
    // Half of the price per area: a merge's planes are those of two vertices.
    let guard = (GUARD * 0.5 * largest_price / mean_area).sqrt();
    (Selection { threshold, guard, max_error, budget: n_left, unit, is_sorted: is_last }, n_wanted)
}
