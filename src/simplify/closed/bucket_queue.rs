//! A priority queue over non-negative costs that keeps their order up to a percent: constant time where a heap
//! takes logarithmic, and the order of edges of nearly equal cost does not matter to a collapse.

/// Mantissa bits that count: buckets are 2^-7 wide, relative to the cost.
const MANTISSA_BITS: u32 = 7;
const SHIFT: u32 = 23 - MANTISSA_BITS;
const N_BUCKETS: usize = (0x7f80_0000 >> SHIFT) as usize + 1;
const NONE: u32 = u32::MAX;

/// Items by cost: the first ones sorted once, later ones in a list per bucket, last in, first out.
pub(super) struct BucketQueue<T> {
    /// The items it began with, their buckets falling, so that the next one stands last.
    sorted: Vec<(u32, T)>,
    heads: Vec<u32>,
    slots: Vec<(T, u32)>,
    free: u32,
    /// No list before this one holds an item.
    lowest: usize,
}

impl<T: Copy> BucketQueue<T> {
    /// Width of a bucket, relative to its costs.
    pub const WIDTH: f32 = 1.0 / (1 << MANTISSA_BITS) as f32;

    /// A queue that begins with `items` and their costs.
    pub fn new(items: impl ExactSizeIterator<Item = (f32, T)> + Clone) -> Self {
        let mut starts = vec![0u32; N_BUCKETS + 1];
        items.clone().for_each(|(cost, _)| starts[N_BUCKETS - 1 - bucket(cost)] += 1);
        let mut sum = 0;
        for start in &mut starts {
            sum += std::mem::replace(start, sum);
        }
        let mut sorted: Vec<Option<(u32, T)>> = vec![None; items.len()];
        for (cost, item) in items {
            let place = &mut starts[N_BUCKETS - 1 - bucket(cost)];
            sorted[*place as usize] = Some((bucket(cost) as u32, item));
            *place += 1;
        }
        let sorted = sorted.into_iter().flatten().collect();
        Self { sorted, heads: vec![NONE; N_BUCKETS], slots: Vec::new(), free: NONE, lowest: N_BUCKETS }
    }

    /// Puts an item in; a cost that is not a number counts as the largest, one below zero as zero.
    pub fn push(&mut self, cost: f32, item: T) {
        let bucket = bucket(cost);
        let slot = (item, self.heads[bucket]);
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

    /// Takes out an item of the lowest bucket.
    pub fn pop(&mut self) -> Option<T> {
        let next = self.sorted.last().map_or(N_BUCKETS, |&(bucket, _)| bucket as usize);
        while self.lowest < next && self.heads[self.lowest] == NONE {
            self.lowest += 1;
        }
        if self.lowest >= next {
            return self.sorted.pop().map(|(_, item)| item);
        }
        let place = self.heads[self.lowest];
        let (item, after) = self.slots[place as usize];
        self.heads[self.lowest] = after;
        self.slots[place as usize].1 = self.free;
        self.free = place;
        Some(item)
    }
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
        let mut queue = BucketQueue::new(first.iter().map(|&cost| (cost, cost)));
        later.iter().for_each(|&cost| queue.push(cost, cost));
        let out: Vec<f32> = std::iter::from_fn(|| queue.pop()).collect();
        assert_eq!(out.len(), costs.len());
        let in_order = |w: &[f32]| w[1] >= w[0] * (1.0 - 1.0 / 128.0) || w[0] < f32::MIN_POSITIVE;
        assert!(out[..out.len() - 2].windows(2).all(in_order));
    }

    #[test]
    fn cheaper_items_that_come_late_come_out_first() {
        let mut queue = BucketQueue::new([(5.0, 'b'), (7.0, 'c')].into_iter());
        assert_eq!(queue.pop(), Some('b'));
        queue.push(1.0, 'a');
        queue.push(9.0, 'd');
        assert_eq!([(); 4].map(|()| queue.pop()), [Some('a'), Some('c'), Some('d'), None]);
    }
}
