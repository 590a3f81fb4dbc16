//! Boxes near boxes of other kinds, or near seeds.

use rayon::join;
use rayon::prelude::*;

use super::Bounds;

/// Largest set that is not halved: testing its pairs takes no longer.
const FEW: usize = 16;
/// Largest share of boxes in both halves at which a cell is halved.
// Above it, the boxes are about as large as the cell.
const MOST_SHARED: f64 = 0.5;
/// Largest number of copies to halves per box.
// Twenty halvings separate a million boxes; boxes across a cut are copied twice.
const MOST_COPIES: f64 = 100.0;
const CHUNK: usize = 8192;

/// Splits `set` into small sets of indices, ascending; boxes that overlap one of another kind share a set with it.
// Halving space is faster than a tree if few kinds are near each other: cells of one kind are dropped early.
pub(crate) fn sets_of_several_kinds(boxes: &[(Bounds, u32)], set: Vec<u32>) -> Vec<Vec<u32>> {
    let everywhere = Bounds { low: [f32::NEG_INFINITY; 3], high: [f32::INFINITY; 3] };
    halve(boxes, set, everywhere, MOST_COPIES)
}

fn halve(boxes: &[(Bounds, u32)], set: Vec<u32>, cell: Bounds, n_copies: f64) -> Vec<Vec<u32>> {
    let bounds = |i: u32| &boxes[i as usize].0;
    if set.iter().all(|&i| boxes[i as usize].1 == boxes[set[0] as usize].1) {
        return Vec::new();
    }
    if set.len() <= FEW {
        return vec![set];
    }
    // The union is clipped to the cell: large boxes would keep the cut in place.
    let all = set.iter().fold(Bounds::EMPTY, |all, &i| all.union(bounds(i)));
    let low = std::array::from_fn(|axis| all.low[axis].max(cell.low[axis]));
    let high = std::array::from_fn(|axis| all.high[axis].min(cell.high[axis]));
    let axis = longest_axis(&Bounds { low, high });
    let cut = 0.5 * (low[axis] + high[axis]);
    let below: Vec<u32> = set.iter().copied().filter(|&i| bounds(i).low[axis] <= cut).collect();
    let above: Vec<u32> = set.iter().copied().filter(|&i| bounds(i).high[axis] >= cut).collect();
    let growth = (below.len() + above.len()) as f64 / set.len() as f64;
    let n_copies = n_copies / growth - 1.0;
    if n_copies < 0.0 || growth > 1.0 + MOST_SHARED {
        return vec![set];
    }
    let mut cells = [Bounds { low, high }; 2];
    (cells[0].high[axis], cells[1].low[axis]) = (cut, cut);
    let (mut sets, more) = join(|| halve(boxes, below, cells[0], n_copies), || halve(boxes, above, cells[1], n_copies));
    sets.extend(more);
    sets
}

/// Returns the indices below `n` whose `bounds` overlap one of `seeds`, ascending.
pub(crate) fn boxes_near(mut seeds: Vec<Bounds>, n: usize, bounds: impl Fn(u32) -> Bounds + Sync) -> Vec<u32> {
    let mut nodes = Vec::with_capacity(2 * seeds.len() + 1);
    add_nodes(&mut seeds, &mut nodes);
    let is_near = |&i: &u32| overlaps_any(&nodes, seeds.len(), &bounds(i));
    (0..n as u32).into_par_iter().with_min_len(CHUNK).filter(is_near).collect()
}

/// Appends a tree: a node over all boxes, the tree over one half, the tree over the other.
fn add_nodes(boxes: &mut [Bounds], nodes: &mut Vec<Bounds>) {
    let all = boxes.iter().fold(Bounds::EMPTY, |all, bounds| all.union(bounds));
    nodes.push(all);
    if boxes.len() > 1 {
        let axis = longest_axis(&all);
        let middle = |bounds: &Bounds| bounds.low[axis] + bounds.high[axis];
        let half = boxes.len() / 2;
        boxes.select_nth_unstable_by(half, |a, b| middle(a).total_cmp(&middle(b)));
        let (one, other) = boxes.split_at_mut(half);
        add_nodes(one, nodes);
        add_nodes(other, nodes);
    }
}

/// Returns whether a box overlaps one of the `n` boxes of a tree.
fn overlaps_any(nodes: &[Bounds], n: usize, bounds: &Bounds) -> bool {
    let half = n / 2;
    nodes[0].overlaps(bounds)
        && (n == 1 || overlaps_any(&nodes[1..], half, bounds) || overlaps_any(&nodes[2 * half..], n - half, bounds))
}

fn longest_axis(bounds: &Bounds) -> usize {
    let length = |axis: usize| bounds.high[axis] - bounds.low[axis];
    (1..3).fold(0, |longest, axis| if length(axis) > length(longest) { axis } else { longest })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rand_xoshiro::rand_core::{Rng, SeedableRng};

    fn random_boxes(n: usize, sizes: [f32; 2]) -> Vec<(Bounds, u32)> {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(n as u64);
        let mut unit = || rng.next_u32() as f32 / u32::MAX as f32;
        let mut random_box = |i: usize| {
            let low = [unit(), unit(), unit()];
            (Bounds { low, high: low.map(|x| x + sizes[i % 2] * unit()) }, (3.0 * low[0]) as u32)
        };
        (0..n).map(&mut random_box).collect()
    }

    #[test]
    fn overlapping_boxes_of_different_kinds_share_a_set_and_sets_are_small() {
        for sizes in [[0.01, 0.01], [0.02, 0.5], [0.0, 0.1]] {
            let boxes = random_boxes(2000, sizes);
            let sets = sets_of_several_kinds(&boxes, (0..2000).collect());
            assert!(sets.iter().all(|set| set.is_sorted()));
            let meet = |[i, j]: &[usize; 2]| boxes[*i].1 != boxes[*j].1 && boxes[*i].0.overlaps(&boxes[*j].0);
            let mut pairs = (0..boxes.len()).flat_map(|j| (0..j).map(move |i| [i, j])).filter(meet);
            let has = |set: &Vec<u32>, i: usize| set.binary_search(&(i as u32)).is_ok();
            assert!(pairs.all(|[i, j]| sets.iter().any(|set| has(set, i) && has(set, j))));
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
        let near = (0..).zip(boxes).filter(|(_, it)| seeds.iter().any(|seed| seed.overlaps(it)));
        assert_eq!(found, near.map(|(i, _)| i).collect::<Vec<u32>>());
        assert!(boxes_near(Vec::new(), boxes.len(), |i| boxes[i as usize]).is_empty());
    }

    #[test]
    fn boxes_that_cannot_be_separated_end_the_search() {
        let same = Bounds { low: [0.0; 3], high: [1.0; 3] };
        let boxes = |bounds: &dyn Fn(i32) -> Bounds| (0..20_000).map(|i| (bounds(i), i as u32 % 2)).collect::<Vec<_>>();
        let all = || (0..20_000).collect();
        assert_eq!(sets_of_several_kinds(&boxes(&|_| same), all()).len(), 1);
        let nested =
            sets_of_several_kinds(&boxes(&|i| Bounds { low: [0.0; 3], high: [0.9f32.powi(i % 300); 3] }), all());
        assert!(!nested.is_empty() && nested.iter().map(Vec::len).sum::<usize>() < 400_000);
    }
}
