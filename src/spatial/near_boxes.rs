//! Which boxes come near others: of other kinds, or of a few that are given.
//!
//! Among kinds by halving space, which is quicker than a tree where few come near: what lies among its own kind is left out early.
//! Small sets are left in the end, of which each box may be compared with each.

use rayon::join;
use rayon::prelude::*;

use super::Bounds;

/// So few boxes are a set: comparing each with each takes no longer than telling them apart.
const FEW: usize = 16;
/// Boxes in both halves of a cell, over all in it, from which on halving tells no more apart: the boxes are as large as the cell.
const MOST_SHARED: f64 = 0.5;
/// Boxes handed on to halves of cells at most, for each box: twenty halvings tell a million apart, and boxes across a cut are handed
/// on twice. What is left then are sets.
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

/// Returns sets of numbers of boxes, ascending, in which all are together that meet one of another kind, and few others.
pub(crate) fn sets_of_several_kinds(boxes: impl Iterator<Item = (Bounds, u32)>) -> Vec<Vec<u32>> {
    let items: Vec<Item> = boxes.zip(0..).map(|((bounds, kind), number)| Item { bounds, kind, number }).collect();
    let everywhere = Bounds { low: [f32::NEG_INFINITY; 3], high: [f32::INFINITY; 3] };
    let mut sets = Vec::new();
    collect_sets(&items, everywhere, MOST_STEPS * items.len(), &mut sets);
    sets
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

/// Appends sets of the items in a cell, those of several kinds, made in at most `n_steps` steps.
fn collect_sets(items: &[Item], cell: Bounds, n_steps: usize, sets: &mut Vec<Vec<u32>>) {
    if items.iter().all(|item| item.kind == items[0].kind) {
        return;
    }
    let mut end = || sets.push(items.iter().map(|item| item.number).collect());
    if items.len() <= FEW {
        return end();
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
    let n_shared = n_items - items.len();
    if n_items > n_steps || n_shared as f64 > MOST_SHARED * items.len() as f64 {
        return end();
    }
    let (mut cells, steps) = ([Bounds { low, high }; 2], (n_steps - n_items) as f64 / n_items as f64);
    (cells[0].high[axis], cells[1].low[axis]) = (cut, cut);
    let collect = |items: &[Item], cell: Bounds, sets: &mut Vec<Vec<u32>>| {
        collect_sets(items, cell, (steps * items.len() as f64) as usize, sets);
    };
    if items.len() > PARALLEL {
        let mut more = Vec::new();
        join(|| collect(&below, cells[0], sets), || collect(&above, cells[1], &mut more));
        sets.extend(more);
    } else {
        collect(&below, cells[0], sets);
        collect(&above, cells[1], sets);
    }
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

    /// All pairs of boxes of different kinds that meet.
    fn pairs(boxes: &[(Bounds, u32)]) -> Vec<[usize; 2]> {
        let meet = |[i, j]: &[usize; 2]| boxes[*i].1 != boxes[*j].1 && boxes[*i].0.overlaps(&boxes[*j].0);
        (0..boxes.len()).flat_map(|j| (0..j).map(move |i| [i, j])).filter(meet).collect()
    }

    #[test]
    fn boxes_of_different_kinds_that_meet_are_in_one_set_and_sets_are_small() {
        for sizes in [[0.01, 0.01], [0.02, 0.5], [0.0, 0.1]] {
            let boxes = random_boxes(2000, sizes);
            let sets = sets_of_several_kinds(boxes.iter().copied());
            assert!(sets.iter().all(|set| set.is_sorted()));
            let has = |set: &Vec<u32>, i: usize| set.binary_search(&(i as u32)).is_ok();
            assert!(pairs(&boxes).into_iter().all(|[i, j]| sets.iter().any(|set| has(set, i) && has(set, j))));
            let n_pairs: usize = sets.iter().map(|set| set.len() * set.len() / 2).sum();
            // A quarter of all pairs, though half of the boxes may be half as large as the space.
            assert!(n_pairs < boxes.len() * boxes.len() / 8, "{n_pairs}");
        }
    }

    #[test]
    fn boxes_near_seeds_are_found() {
        let boxes: Vec<Bounds> = random_boxes(3000, [0.02, 0.05]).into_iter().map(|it| it.0).collect();
        let (seeds, boxes) = boxes.split_at(10);
        let found = boxes_near(seeds.to_vec(), boxes.len(), |i| boxes[i as usize]);
        let met = (0..).zip(boxes).filter(|(_, it)| seeds.iter().any(|seed| seed.overlaps(it)));
        assert_eq!(found, met.map(|(i, _)| i).collect::<Vec<u32>>());
        assert!(boxes_near(Vec::new(), boxes.len(), |i| boxes[i as usize]).is_empty());
    }

    #[test]
    fn boxes_that_cannot_be_told_apart_end_the_search() {
        let same = Bounds { low: [0.0; 3], high: [1.0; 3] };
        assert_eq!(sets_of_several_kinds((0..20_000).map(|i| (same, i % 2))).len(), 1);
        let nested = (0..20_000).map(|i| (Bounds { low: [0.0; 3], high: [0.9f32.powi(i % 300); 3] }, i as u32 % 2));
        let sets = sets_of_several_kinds(nested);
        assert!(!sets.is_empty() && sets.iter().map(Vec::len).sum::<usize>() < 400_000);
    }
}
