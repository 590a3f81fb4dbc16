//! Visits: which vertices of a stretch try to merge with the neighbour of their best price, and in which order.

use crate::collapse::boundary::merge_at_boundary;
use crate::collapse::lanes::{EightLanes, Kernel};
use crate::collapse::merge::{Border, EdgeToMerge, merge_inside};
use crate::collapse::merges::PassMerge;
use crate::collapse::rings::{Vertex, state};
use crate::collapse::stretch::{PassView, Refusal, VertexStretch};
use crate::collapse::vector::subtract;

/// Which vertices are visited; all of them only if their price is within the threshold.
#[derive(Clone, Copy)]
pub(crate) enum Order<'a> {
    /// Those of the stretch, as they are in memory.
    InMemory,
    /// These, in their order, counted from the mesh's first.
    Listed(&'a [u32]),
}

/// What one unit of the budget is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Unit {
    Face,
    Vertex,
}

/// Merges in one stretch until the budget is spent.
pub(crate) struct Visit<'a> {
    pub pass: PassView<'a>,
    pub stretch: VertexStretch<'a>,
    pub order: Order<'a>,
    /// Most faces or vertices to remove; the last merge may remove one face more.
    pub budget: usize,
    pub unit: Unit,
    pub records_merges: bool,
}

/// What the visits of a stretch did.
#[derive(Default)]
pub(crate) struct Tally {
    pub n_merges: usize,
    pub n_faces: usize,
    /// Vertices whose merge reaches out of the stretch, in the order of visits.
    pub outside: Vec<u32>,
    /// The merges in their order, if they are recorded.
    pub merges: Vec<PassMerge>,
}

impl Tally {
    pub(crate) fn count_spent(&self, unit: Unit) -> usize {
        if unit == Unit::Face { self.n_faces } else { self.n_merges }
    }

    /// Takes the merges, with vertices named by their origins and with folds by the vertices `before` the pass.
    pub(crate) fn take_merges(&mut self, origins: &[u32], before: &[Vertex]) -> Vec<PassMerge> {
        let mut merges = std::mem::take(&mut self.merges);
        for merge in &mut merges {
            merge.find_folds(before);
            merge.rename(origins);
        }
        merges
    }

    pub(crate) fn add(&mut self, later: Tally) {
        self.n_merges += later.n_merges;
        self.n_faces += later.n_faces;
        self.outside.extend(later.outside);
        self.merges.extend(later.merges);
    }
}

impl Kernel for Visit<'_> {
    type Output = Tally;

    #[inline(always)]
    fn run<L: EightLanes>(mut self) -> Tally {
        let mut tally = Tally::default();
        let mut border = Border::default();
        let first = self.stretch.first;
        let n = if let Order::Listed(list) = self.order { list.len() } else { self.stretch.vertices.len() };
        for i in 0..n {
            let u = if let Order::Listed(list) = self.order { list[i] } else { first + i as u32 };
            let best = self.stretch.best[(u - first) as usize];
            if (best >> 32) as u32 > self.pass.threshold {
                continue;
            }
            if tally.count_spent(self.unit) >= self.budget {
                break;
            }
            match self.try_merge::<L>(&mut border, u, best, &mut tally.merges) {
                None => {}
                Some(Ok(n_faces)) => {
                    tally.n_merges += 1;
                    tally.n_faces += n_faces;
                }
                Some(Err(Refusal::Outside)) => tally.outside.push(u),
                Some(Err(_)) => self.remember_refusal(u, best as u32),
            }
        }
        tally
    }
}

impl Visit<'_> {
    // None if one end was in a merge of this pass; else how many faces went.
    #[inline(always)]
    fn try_merge<L: EightLanes>(
        &mut self,
        border: &mut Border,
        u: u32,
        best: u64,
        merges: &mut Vec<PassMerge>,
    ) -> Option<Result<usize, Refusal>> {
        let stretch = &self.stretch;
        let v = best as u32;
        let Some(&state_v) = stretch.states.get(v.wrapping_sub(stretch.first) as usize) else {
            return Some(Err(Refusal::Outside));
        };
        let state_u = stretch.states[(u - stretch.first) as usize];
        let either = state_u | state_v;
        if either & (state::MERGED | state::GONE) != 0 {
            return None;
        }
        let Some((edge, is_free)) = self.direct(u, v, [state_u, state_v]) else { return Some(Err(Refusal::Topology)) };
        let price = f32::from_bits((best >> 32) as u32);
        let is_fixed = !(is_free && self.pass.terms.moves);
        let loss = self.pass.terms.find_loss(self.pass.rings, edge, is_fixed);
        let edge = EdgeToMerge { u: edge[0], v: edge[1], price, loss, is_fixed };
        let is_inside = either & state::BOUNDARY == 0;
        let merged = if is_inside {
            merge_inside::<L>(&self.pass, &mut self.stretch, border, edge).map(|seen| (2, seen))
        } else {
            merge_at_boundary(&self.pass, &mut self.stretch, edge)
        };
        if let (true, Ok((_, seen))) = (self.records_merges, &merged) {
            let star = is_inside.then(|| border.vertices());
            merges.push(PassMerge::new(self.pass.rings, &self.stretch, [edge.u, edge.v], *seen, star));
        }
        Some(merged.map(|(n_faces, _)| n_faces))
    }

    // The end that stays, then the one that goes, and whether both could go; none if neither may.
    #[inline(always)]
    fn direct(&self, u: u32, v: u32, [state_u, state_v]: [u8; 2]) -> Option<([u32; 2], bool)> {
        let PassView { rings, terms, .. } = self.pass;
        if (state_u | state_v) & state::HELD != 0 {
            match (rings.may_go((u, state_u), (v, state_v)), rings.may_go((v, state_v), (u, state_u))) {
                (false, false) => return None,
                (true, false) => return Some(([v, u], false)),
                (false, true) => return Some(([u, v], false)),
                (true, true) => {}
            }
        }
        if terms.moves {
            return Some(([u, v], true));
        }
        let position = |w: u32| self.stretch.vertices[(w - self.stretch.first) as usize].position;
        let d = subtract(position(v), position(u));
        let is_reversed = terms.price_at(rings, u, v, d) < terms.price_at(rings, v, u, d.map(|x| -x));
        Some((if is_reversed { [v, u] } else { [u, v] }, true))
    }

    fn remember_refusal(&mut self, u: u32, v: u32) {
        let i = (u - self.stretch.first) as usize;
        let state = &mut self.stretch.states[i];
        if *state & state::REFUSED != 0 {
            *state |= state::RESTS;
        }
        *state |= state::REFUSED;
        self.stretch.refused[i] = v;
    }
}
