//! A priority queue over non-negative costs that keeps their order up to a percent: constant time where a heap
//! takes logarithmic, and the order of edges of nearly equal cost does not matter to a collapse.

/// Mantissa bits that count: buckets are 2^-7 wide, relative to the cost.
const MANTISSA_BITS: u32 = 7;
const SHIFT: u32 = 23 - MANTISSA_BITS;
const N_BUCKETS: usize = (0x7f80_0000 >> SHIFT) as usize + 1;
const NONE: u32 = u32::MAX;
/// Bits of a bucket's number that bins leave out.
const BIN_BITS: u32 = 2;

/// Items by cost: the first ones sorted once, later ones in a list per bucket, last in, first out.
pub(super) struct BucketQueue<T> {
    /// The costs and items it began with, their buckets falling, so that the next one stands last.
    sorted: Vec<(f32, T)>,
    heads: Vec<u32>,
    slots: Vec<((f32, T), u32)>,
    free: u32,
    /// No list before this one holds an item.
    lowest: usize,
}

impl<T: Copy + Default> Default for BucketQueue<T> {
    fn default() -> Self {
        Self { sorted: Vec::new(), heads: vec![NONE; N_BUCKETS], slots: Vec::new(), free: NONE, lowest: N_BUCKETS }
    }
}

impl<T: Copy + Default> BucketQueue<T> {
    /// Width of a bucket, relative to its costs.
    pub const WIDTH: f32 = 1.0 / (1 << MANTISSA_BITS) as f32;

    /// A queue that begins with the cheapest of `items`, at least as many as are wanted, by their costs, and up to which
    /// cost it holds all of them. Those of infinite cost are left out.
    pub fn new(items: impl Iterator<Item = (f32, T)> + Clone, wanted: usize) -> (Self, f32) {
        let mut starts = vec![0u32; N_BUCKETS];
        items.clone().for_each(|(cost, _)| starts[bucket(cost)] += 1);
        let last = N_BUCKETS - 1;
        let (mut n_items, mut end) = (0, 0);
        while end < last && n_items < wanted {
            n_items += starts[end] as usize;
            end += 1;
        }
        // From the costliest bucket down, so that the next item stands last.
        let mut sum = 0;
        starts[..end].iter_mut().rev().for_each(|start| sum += std::mem::replace(start, sum));
        let mut sorted = vec![(0.0, T::default()); n_items];
        for (cost, item) in items.filter(|&(cost, _)| bucket(cost) < end) {
            let place = &mut starts[bucket(cost)];
            sorted[*place as usize] = (cost, item);
            *place += 1;
        }
        let most = if end == last { f32::INFINITY } else { f32::from_bits(((end as u32) << SHIFT) - 1) };
        (Self { sorted, ..Self::default() }, most)
    }

    /// Puts an item in; a cost that is not a number counts as the largest, one below zero as zero.
    pub fn push(&mut self, cost: f32, item: T) {
        let bucket = bucket(cost);
        let slot = ((cost, item), self.heads[bucket]);
        self.heads[bucket] = if self.free == NONE {
            self.slots.push(slot);
            self.slots.len() as u32 - 1
        } else {
            let place = self.free;
            self.free = self.slots[place as usize].1;
            self.slots[place as usize] = slot;
            place
        };
        self.lowest = self.lowest.min(bucket);
    }

    /// Takes out an item of the lowest bucket and its cost, unless that bucket lies above the one of `most`.
    pub fn pop(&mut self, most: f32) -> Option<(f32, T)> {
        let next = self.sorted.last().map_or(N_BUCKETS, |&(cost, _)| bucket(cost));
        while self.lowest < next && self.heads[self.lowest] == NONE {
            self.lowest += 1;
        }
        if self.lowest.min(next) > bucket(most) {
            return None;
        }
        if self.lowest >= next {
            return self.sorted.pop();
        }
        let place = self.heads[self.lowest];
        let (item, after) = self.slots[place as usize];
        self.heads[self.lowest] = after;
        self.slots[place as usize].1 = self.free;
        self.free = place;
        Some(item)
    }

    /// How many items there are by cost, in [`N_BINS`] bins, coarser than buckets.
    pub fn counts(&self) -> Vec<u32> {
        let mut counts = vec![0; N_BINS];
        self.sorted.iter().for_each(|&(cost, _)| counts[bin(cost)] += 1);
        for bucket in self.lowest..N_BUCKETS {
            let mut place = self.heads[bucket];
            while place != NONE {
                counts[bucket >> BIN_BITS] += 1;
                place = self.slots[place as usize].1;
            }
        }
        counts
    }
}

/// Numbers of items by cost, which [`BucketQueue::count`] counts.
pub(super) const N_BINS: usize = (N_BUCKETS >> BIN_BITS) + 1;

/// The largest cost in a bin.
pub(super) fn cost_of(bin: usize) -> f32 {
    f32::from_bits((((bin + 1) << (SHIFT + BIN_BITS)) - 1).min(f32::MAX.to_bits() as usize) as u32)
}

fn bin(cost: f32) -> usize {
    bucket(cost) >> BIN_BITS
}

fn bucket(cost: f32) -> usize {
    let cost = if cost.is_nan() { f32::INFINITY } else { cost.max(0.0) };
    (cost.to_bits() >> SHIFT) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_come_out_by_cost_up_to_a_percent() {
        let mut costs: Vec<f32> = (0..2000).map(|i: u32| (i.wrapping_mul(2_654_435_761) as f32).powi(3)).collect();
        costs.extend([0.0, 1e-38, 1e-42, f32::INFINITY, f32::NAN, f32::MAX]);
        let (first, later) = costs.split_at(900);
        let (mut queue, most) = BucketQueue::new(first.iter().map(|&cost| (cost, cost)), usize::MAX);
        assert_eq!(most, f32::INFINITY);
        later.iter().for_each(|&cost| queue.push(cost, cost));
        let counts = queue.counts();
        for at in [0, 1000, N_BINS - 1, bin(costs[17])] {
            let n_below = costs.iter().filter(|&&cost| bin(cost) <= at).count();
            assert_eq!(counts[..=at].iter().sum::<u32>() as usize, n_below);
        }
        let out: Vec<f32> = std::iter::from_fn(|| queue.pop(f32::INFINITY)).map(|(_, item)| item).collect();
        assert_eq!(out.len(), costs.len());
        let in_order = |w: &[f32]| w[1] >= w[0] * (1.0 - 1.0 / 128.0) || w[0] < f32::MIN_POSITIVE;
        assert!(out[..out.len() - 2].windows(2).all(in_order));
    }

    #[test]
    fn cheaper_items_that_come_late_come_out_first() {
        let (mut queue, _) = BucketQueue::new([(5.0, 'b'), (7.0, 'c'), (f32::INFINITY, 'e')].into_iter(), 9);
        assert_eq!(queue.pop(4.0), None);
        assert_eq!(queue.pop(5.0), Some((5.0, 'b')));
        queue.push(1.0, 'a');
        queue.push(9.0, 'd');
        assert_eq!([(); 3].map(|()| queue.pop(8.0)), [Some((1.0, 'a')), Some((7.0, 'c')), None]);
        assert_eq!([(); 2].map(|()| queue.pop(f32::INFINITY)), [Some((9.0, 'd')), None]);
    }

    #[test]
    fn a_queue_of_the_cheapest_items_says_up_to_which_cost_it_has_all() {
        let costs: Vec<f32> = (0..1000u32).map(|i| (i.wrapping_mul(2_654_435_761) % 997) as f32).collect();
        for wanted in [1, 10, 300, 999, 1000, 2000] {
            let (mut queue, most) = BucketQueue::new(costs.iter().map(|&cost| (cost, cost)), wanted);
            let n_held = std::iter::from_fn(|| queue.pop(f32::INFINITY)).count();
            assert!(n_held >= wanted.min(1000), "{wanted}");
            assert_eq!(n_held, costs.iter().filter(|&&cost| cost <= most).count());
        }
    }
}
