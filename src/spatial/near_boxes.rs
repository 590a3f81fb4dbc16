//! Which boxes come near others: of other kinds, or of a few that are given.
//!
//! Among kinds by halving space, which is quicker than a tree where few come near: what lies among its own kind is left out early.

use rayon::join;
use rayon::prelude::*;

use super::Bounds;

/// So few boxes are compared each with each.
const FEW: usize = 12;
/// Boxes in both halves of a cell, over all in it, from which on halving tells no more apart: the boxes are as large as the cell.
const MOST_SHARED: f64 = 0.5;
/// Boxes handed on to halves of cells at most, for each box: twenty halvings tell a million apart, and boxes across a cut are handed
/// on twice. What is left then counts as near.
const MOST_STEPS: usize = 100;
/// Cells with more boxes are halved on two threads, and so many boxes looked at by one.
const PARALLEL: usize = 8192;

/// A box of one kind.
#[derive(Clone, Copy)]
struct Item {
    bounds: Bounds,
    kind: u32,
    number: u32,
}

/// Returns the numbers of all boxes that meet one of another kind, ascending, perhaps with some that only lie near one.
pub(crate) fn boxes_near_other_kinds(boxes: impl Iterator<Item = (Bounds, u32)>) -> Vec<u32> {
    let items: Vec<Item> = boxes.zip(0..).map(|((bounds, kind), number)| Item { bounds, kind, number }).collect();
    let everywhere = Bounds { low: [f32::NEG_INFINITY; 3], high: [f32::INFINITY; 3] };
    let mut near = near_others(&items, everywhere, MOST_STEPS * items.len());
    near.sort_unstable();
    near.dedup();
    near
}

/// Returns those numbers below `n` whose `bounds` meet one of `seeds`, ascending.
pub(crate) fn boxes_near(mut seeds: Vec<Bounds>, n: usize, bounds: impl Fn(u32) -> Bounds + Sync) -> Vec<u32> {
    let mut nodes = Vec::with_capacity(2 * seeds.len());
    grow(&mut seeds, &mut nodes);
    let is_near = |&i: &u32| !nodes.is_empty() && meets(&nodes, seeds.len(), &bounds(i));
    (0..n as u32).into_par_iter().with_min_len(PARALLEL).filter(is_near).collect()
}

/// Appends a tree over boxes: a node around all, the tree over one half, the tree over the other.
fn grow(boxes: &mut [Bounds], nodes: &mut Vec<Bounds>) {
    let Some(all) = boxes.iter().copied().reduce(|all, bounds| all.union(&bounds)) else { return };
    nodes.push(all);
    if boxes.len() > 1 {
        let (axis, half) = (longest_axis(&all), boxes.len() / 2);
        let middle = |bounds: &Bounds| bounds.low[axis] + bounds.high[axis];
        boxes.select_nth_unstable_by(half, |a, b| middle(a).total_cmp(&middle(b)));
        let (one, other) = boxes.split_at_mut(half);
        grow(one, nodes);
        grow(other, nodes);
    }
}

/// Whether a box meets one of the `n` that a tree is over.
fn meets(nodes: &[Bounds], n: usize, bounds: &Bounds) -> bool {
    let half = n / 2;
    nodes[0].overlaps(bounds)
        && (n == 1 || meets(&nodes[1..], half, bounds) || meets(&nodes[2 * half..], n - half, bounds))
}

/// Returns the axis along which a box is longest.
fn longest_axis(bounds: &Bounds) -> usize {
    let length = |axis: usize| bounds.high[axis] - bounds.low[axis];
    (1..3).fold(0, |longest, axis| if length(axis) > length(longest) { axis } else { longest })
}

/// Collects the items in a cell that meet one of another kind, in no order and perhaps several times, in at most `n_steps` steps.
fn near_others(items: &[Item], cell: Bounds, n_steps: usize) -> Vec<u32> {
    if items.iter().all(|item| item.kind == items[0].kind) {
        return Vec::new();
    }
    if items.len() <= FEW {
        return items.iter().filter(|item| meets_other(item, items)).map(|item| item.number).collect();
    }
    let all = items.iter().fold(Bounds::EMPTY, |bounds, item| bounds.union(&item.bounds));
    // What reaches beyond the cell is cut there, or large boxes would keep the cut where it was.
    let low = std::array::from_fn(|axis| all.low[axis].max(cell.low[axis]));
    let high = std::array::from_fn(|axis| all.high[axis].min(cell.high[axis]));
    let axis = longest_axis(&Bounds { low, high });
    let cut = 0.5 * (low[axis] + high[axis]);
    let below: Vec<Item> = items.iter().filter(|item| item.bounds.low[axis] <= cut).copied().collect();
    let above: Vec<Item> = items.iter().filter(|item| item.bounds.high[axis] >= cut).copied().collect();
    let n_items = below.len() + above.len();
    if n_items > n_steps || (n_items - items.len()) as f64 > MOST_SHARED * items.len() as f64 {
        return items.iter().map(|item| item.number).collect();
    }
    let (mut cells, steps) = ([Bounds { low, high }; 2], (n_steps - n_items) as f64 / n_items as f64);
    (cells[0].high[axis], cells[1].low[axis]) = (cut, cut);
    let near = |items: &[Item], cell: Bounds| near_others(items, cell, (steps * items.len() as f64) as usize);
    let (mut near, more) = if items.len() > PARALLEL {
        join(|| near(&below, cells[0]), || near(&above, cells[1]))
    } else {
        (near(&below, cells[0]), near(&above, cells[1]))
    };
    near.extend(more);
    near
}

/// Whether an item meets one of another kind.
fn meets_other(item: &Item, items: &[Item]) -> bool {
    items.iter().any(|other| other.kind != item.kind && other.bounds.overlaps(&item.bounds))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rand_xoshiro::rand_core::{Rng, SeedableRng};

    /// Random boxes of a few kinds, of sizes up to one of these.
    fn random_boxes(n: usize, sizes: [f32; 2]) -> Vec<(Bounds, u32)> {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(n as u64);
        let mut unit = || rng.next_u32() as f32 / u32::MAX as f32;
        let mut random_box = |i: usize| {
            let low = [unit(), unit(), unit()];
            (Bounds { low, high: low.map(|x| x + sizes[i % 2] * unit()) }, (3.0 * low[0]) as u32)
        };
        (0..n).map(&mut random_box).collect()
    }

    fn naive(boxes: &[(Bounds, u32)]) -> Vec<u32> {
        let meets = |(a, kind): &(Bounds, u32)| boxes.iter().any(|(b, other)| other != kind && a.overlaps(b));
        (0..).zip(boxes).filter(|(_, labelled)| meets(labelled)).map(|(i, _)| i).collect()
    }

    #[test]
    fn every_box_that_meets_another_kind_is_found_and_most_others_are_not() {
        for sizes in [[0.01, 0.01], [0.02, 0.5], [0.0, 0.1]] {
            let boxes = random_boxes(2000, sizes);
            let (found, expected) = (boxes_near_other_kinds(boxes.iter().copied()), naive(&boxes));
            assert!(found.is_sorted() && expected.iter().all(|i| found.binary_search(i).is_ok()));
            assert!(found.len() <= expected.len() + 400, "{} {}", found.len(), expected.len());
        }
    }

    #[test]
    fn boxes_near_seeds_are_found() {
        let boxes: Vec<Bounds> = random_boxes(3000, [0.02, 0.05]).into_iter().map(|it| it.0).collect();
        let (seeds, boxes) = boxes.split_at(10);
        let found = boxes_near(seeds.to_vec(), boxes.len(), |i| boxes[i as usize]);
        let met = (0..).zip(boxes).filter(|(_, it)| seeds.iter().any(|seed| seed.overlaps(it)));
        assert_eq!(found, met.map(|(i, _)| i).collect::<Vec<u32>>());
        assert_eq!(boxes_near(Vec::new(), boxes.len(), |i| boxes[i as usize]), []);
    }

    #[test]
    fn boxes_that_cannot_be_told_apart_end_the_search() {
        let same = Bounds { low: [0.0; 3], high: [1.0; 3] };
        let boxes = || (0..20_000).map(|i| (same, i % 2));
        assert_eq!(boxes_near_other_kinds(boxes()).len(), 20_000);
        let nested = (0..20_000).map(|i| (Bounds { low: [0.0; 3], high: [0.9f32.powi(i % 300); 3] }, i as u32 % 2));
        assert_eq!(boxes_near_other_kinds(nested).len(), 20_000);
    }
}
