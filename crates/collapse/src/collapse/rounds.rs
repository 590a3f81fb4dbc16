//! The merges of a pass, in stretches on several threads.
//!
//! A vertex whose star reaches into another stretch waits for the second round, whose stretches lie across the borders of
//! the first; the few left come last, all in one. Stretches depend on the mesh and the pass alone, so the result has the
//! same bits on any number of threads.

use std::ops::Range;

use crate::collapse::lanes::dispatch;
use crate::collapse::price::PriceTerms;
use crate::collapse::rings::{Rings, RingsView};
use crate::collapse::selection::Selection;
use crate::collapse::stretch::{PassView, VertexStretch};
use crate::collapse::team::{STRETCH, Team, split};
use crate::collapse::visit::{Order, Tally, Visit};

/// Where the first border lies in pass after pass, in eighths of a stretch.
const SHIFTS: [usize; 8] = [8, 4, 2, 6, 3, 7, 1, 5];

/// A mesh and what its merges go by.
pub(crate) struct PassMesh<'a> {
    pub rings: &'a mut Rings,
    pub terms: PriceTerms<'a>,
    /// The best edge of each vertex; after a merge, the other end.
    pub best: &'a mut [u64],
    pub selection: Selection,
    pub records_merges: bool,
    pub team: Team<'a>,
}

/// Merges vertices of the mesh, with stretches that shift from pass to pass.
pub(crate) fn merge_in_rounds(mut mesh: PassMesh, pass: usize) -> Tally {
    let (n, selection) = (mesh.rings.vertices.len(), mesh.selection);
    let whole = || cut_stretches(n, n);
    if selection.is_sorted {
        let list = sort_by_price(mesh.best, selection.threshold);
        return mesh.merge_round(&whole(), &[Order::Listed(&list)], &[selection.budget]);
    }
    if n <= STRETCH + STRETCH / 2 {
        return mesh.merge_round(&whole(), &[Order::InMemory], &[selection.budget]);
    }
    let shift = SHIFTS[pass % SHIFTS.len()] * STRETCH / 8;
    let pieces = cut_stretches(n, shift);
    let counts = count_candidates(mesh.best, &pieces, selection.threshold, mesh.team);
    let orders = vec![Order::InMemory; pieces.len()];
    let mut total = mesh.merge_round(&pieces, &orders, &share_budget(selection.budget, &counts));
    for pieces in [cut_stretches(n, (shift + STRETCH / 2) % STRETCH), whole()] {
        let waiting = std::mem::take(&mut total.outside);
        let lists: Vec<&[u32]> = pieces.iter().map(|piece| cut_list(&waiting, piece)).collect();
        let counts: Vec<usize> = lists.iter().map(|list| list.len()).collect();
        let budgets = share_budget(selection.budget.saturating_sub(total.count_spent(selection.unit)), &counts);
        let orders: Vec<Order> = lists.into_iter().map(Order::Listed).collect();
        let tally = mesh.merge_round(&pieces, &orders, &budgets);
        total.add(tally);
    }
    total
}

impl PassMesh<'_> {
    // Merges in each stretch what is in its order, within its budget.
    fn merge_round(&mut self, pieces: &[Range<usize>], orders: &[Order], budgets: &[usize]) -> Tally {
        let Selection { threshold, price, guard, max_error, unit, .. } = self.selection;
        let (rings, records_merges) = (&mut *self.rings, self.records_merges);
        let kept = RingsView { starts: &rings.starts, neighbors: &rings.neighbors, lines: &rings.lines };
        let pass = PassView { rings: kept, terms: self.terms, threshold, price, guard, max_error };
        let lengths = || pieces.iter().map(|piece| piece.len());
        let mut vertices = split(&mut rings.vertices, lengths()).into_iter();
        let mut degrees = split(&mut rings.degrees, lengths()).into_iter();
        let mut states = split(&mut rings.states, lengths()).into_iter();
        let mut best = split(self.best, lengths()).into_iter();
        let mut refused = split(&mut rings.refused, lengths()).into_iter();
        let mut errors = split(&mut rings.errors, lengths()).into_iter();
        let mut tallies: Vec<Tally> = pieces.iter().map(|_| Tally::default()).collect();
        let stretches = pieces.iter().zip(orders).zip(budgets).zip(&mut tallies);
        let work = stretches.map(|(((piece, &order), &budget), tally)| {
            let stretch = VertexStretch {
                first: piece.start as u32,
                vertices: vertices.next().unwrap_or_default(),
                degrees: degrees.next().unwrap_or_default(),
                states: states.next().unwrap_or_default(),
                best: best.next().unwrap_or_default(),
                refused: refused.next().unwrap_or_default(),
                errors: errors.next().unwrap_or_default(),
            };
            (Visit { pass, stretch, order, budget, unit, records_merges }, tally)
        });
        self.team.run(work.collect(), |(visit, tally)| *tally = dispatch(visit));
        let mut total = Tally::default();
        tallies.into_iter().for_each(|tally| total.add(tally));
        total
    }
}

// Vertices within the threshold, from the cheapest on; equal prices by index.
fn sort_by_price(best: &[u64], threshold: u32) -> Vec<u32> {
    let mut keys: Vec<u64> = Vec::new();
    for (u, best) in best.iter().enumerate() {
        if (best >> 32) as u32 <= threshold {
            keys.push(best >> 32 << 32 | u as u64);
        }
    }
    keys.sort_unstable();
    keys.into_iter().map(|key| key as u32).collect()
}

fn cut_stretches(n: usize, shift: usize) -> Vec<Range<usize>> {
    let mut starts: Vec<usize> = (shift..n).step_by(STRETCH).filter(|&start| start > 0).collect();
    starts.insert(0, 0);
    starts.iter().enumerate().map(|(i, &start)| start..starts.get(i + 1).copied().unwrap_or(n)).collect()
}

// The part of a rising list that is in a piece.
fn cut_list<'a>(list: &'a [u32], piece: &Range<usize>) -> &'a [u32] {
    let place = |bound: usize| list.partition_point(|&u| (u as usize) < bound);
    &list[place(piece.start)..place(piece.end)]
}

fn count_candidates(best: &[u64], pieces: &[Range<usize>], threshold: u32, team: Team) -> Vec<usize> {
    let mut counts = vec![0; pieces.len()];
    team.run(pieces.iter().zip(&mut counts).collect(), |(piece, count)| {
        *count = best[piece.clone()].iter().map(|x| usize::from((x >> 32) as u32 <= threshold)).sum();
    });
    counts
}

// Shares of the budget by the number of candidates, so that stretches together never remove too much.
fn share_budget(budget: usize, counts: &[usize]) -> Vec<usize> {
    let sum = counts.iter().sum::<usize>().max(1);
    // A merge may remove one face more than the rest of its budget, so one is kept back.
    let share = |count: &usize| ((budget as u128 * *count as u128 / sum as u128) as usize).saturating_sub(1);
    if let [_] = counts { vec![budget] } else { counts.iter().map(share).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stretches_cover_all_and_budgets_never_exceed_the_whole() {
        for n in [1, STRETCH, 3 * STRETCH + 5] {
            for shift in [0, 1, STRETCH / 2, STRETCH] {
                let pieces = cut_stretches(n, shift);
                assert_eq!((pieces[0].start, pieces[pieces.len() - 1].end), (0, n));
                assert!(pieces.windows(2).all(|pair| pair[0].end == pair[1].start && !pair[0].is_empty()));
            }
        }
        let budgets = share_budget(100, &[5, 0, 17, 3]);
        assert!(budgets.iter().map(|b| if *b == 0 { 0 } else { b + 1 }).sum::<usize>() <= 100);
        assert_eq!(cut_list(&[1, 5, 9, 12], &(5..12)), [5, 9]);
    }
}
