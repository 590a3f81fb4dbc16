//! Passes: quadrics, prices, threshold, merges and new rings, until the mesh has its size.
//!
//! All merges of a pass go by the quadrics and prices of its beginning, and a vertex is in one merge at most. Early passes
//! merge roughly half of the rest; the last merges from the cheapest edge on, to the exact size.

use crate::collapse::lanes::{VertexQuadric, dispatch};
use crate::collapse::merges::PassMerge;
use crate::collapse::price::{PriceEdges, PriceTerms};
use crate::collapse::quadric::SumQuadrics;
use crate::collapse::rebuild::rebuild;
use crate::collapse::rings::{Rings, state};
use crate::collapse::rounds::{PassMesh, merge_in_rounds};
use crate::collapse::selection::{MergeChooser, SizeGoal};
use crate::collapse::sides::SideArrays;
use crate::collapse::team::{STRETCH, Team};
use crate::collapse::visit::Unit;

/// Squared distance from which on a sample of the fit is of another part of the surface.
///
/// It is over the mean squared distance from planes at the price of the last pass with merges.
const FARTHEST: f32 = 8.0;

const MOST_PASSES: usize = 200;

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
    let mut chooser = MergeChooser::new(goal, start);
    while size > goal.size.max(goal.pause)
        && chooser.has_hope()
        && numbers.len() < most_passes
        && goal.goes_on(start, size)
    {
        if let Some(sides) = &mut sides {
            sides.prepare_pass(rings, &mut arrays.losses);
        }
        price_all(rings, &mut arrays, goal.moves, team);
        let selection = chooser.choose(&arrays.best, &arrays.quadrics, size - goal.size, team);
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
        let price = selection.price / mean_importance(&arrays.quadrics);
        if tally.n_merges > 0 {
            *farthest = FARTHEST * selection.mean_square;
        }
        chooser.count_pass(selection, tally.n_merges, rings);
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
        if rings.states[v as usize] & state::RESTS == 0 {
            let best = &mut arrays.best[v as usize];
            *best = (*best).min(packed);
        }
    }
}
