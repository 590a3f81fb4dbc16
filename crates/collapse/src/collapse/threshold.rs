//! The price up to which vertices are visited in a pass: a rank among the best prices, by two histograms over their bits.

use crate::collapse::team::{STRETCH, Team};

/// A price above that of every edge that can be merged; the bits of the largest float.
pub(crate) const ANY: u32 = 0x7f7f_ffff;

const BINS: usize = 2048;

/// The best prices of all vertices, counted by bits 20 to 30: positive floats are ordered as their bits.
pub(crate) struct PriceRanks<'a> {
    best: &'a [u64],
    coarse: [u32; BINS],
    team: Team<'a>,
}

impl<'a> PriceRanks<'a> {
    pub(crate) fn new(best: &'a [u64], team: Team<'a>) -> PriceRanks<'a> {
        PriceRanks { best, coarse: count(best, 52, None, team), team }
    }

    /// Counts the vertices with an edge that can be merged.
    pub(crate) fn n_candidates(&self) -> usize {
        self.coarse[..ANY as usize >> 20].iter().map(|&n| n as usize).sum()
    }

    /// Returns the bits of a price that at least `n_wanted` vertices are at or below, or the largest if there are fewer.
    pub(crate) fn find_threshold(&self, n_wanted: usize) -> u32 {
        let Some((bin, n_below)) = find_bin(&self.coarse[..ANY as usize >> 20], n_wanted) else { return ANY };
        let fine = count(self.best, 41, Some(bin as u64), self.team);
        let (fine_bin, _) = find_bin(&fine, n_wanted - n_below).unwrap_or((BINS - 1, 0));
        (bin as u32) << 20 | (fine_bin as u32) << 9 | 511
    }
}

// The first bin where the sum reaches `n_wanted`, and the sum before it.
fn find_bin(counts: &[u32], n_wanted: usize) -> Option<(usize, usize)> {
    let mut sum = 0;
    for (bin, &count) in counts.iter().enumerate() {
        if sum + count as usize >= n_wanted {
            return Some((bin, sum));
        }
        sum += count as usize;
    }
    None
}

// How many prices have each value of the eleven bits from `shift` on, among those in a coarse bin.
fn count(best: &[u64], shift: u32, within: Option<u64>, team: Team) -> [u32; BINS] {
    let count_stretch = |best: &[u64], counts: &mut [u32; BINS]| match within {
        None => best.iter().for_each(|x| counts[(x >> shift) as usize & (BINS - 1)] += 1),
        Some(bin) => {
            for x in best.iter().filter(|&x| x >> 52 == bin) {
                counts[(x >> shift) as usize & (BINS - 1)] += 1;
            }
        }
    };
    let mut sums = [0; BINS];
    // For a small mesh a second histogram takes as long as the counting.
    if best.len() <= STRETCH {
        count_stretch(best, &mut sums);
        return sums;
    }
    let mut counts = vec![[0u32; BINS]; best.len().div_ceil(STRETCH)];
    team.run(best.chunks(STRETCH).zip(&mut counts).collect(), |(best, counts)| count_stretch(best, counts));
    for counts in counts {
        for (sum, count) in sums.iter_mut().zip(counts) {
            *sum += count;
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collapse::lanes::pack;

    #[test]
    fn the_threshold_is_the_rank_among_sorted_prices() {
        let price = |i: u32| f32::from_bits(0x3000_0000 + i.wrapping_mul(2_654_435_761) % 0x0a00_0000);
        let mut best: Vec<u64> = (0..5000).map(|i| pack(price(i), i)).collect();
        best.extend([u64::MAX; 50]);
        let mut prices: Vec<u32> = best[..5000].iter().map(|x| (x >> 32) as u32).collect();
        prices.sort_unstable();
        let ranks = PriceRanks::new(&best, Team::alone());
        for n in [1, 10, 700, 5000] {
            assert_eq!(ranks.find_threshold(n), prices[n - 1] | 511);
        }
        assert_eq!(ranks.find_threshold(5001), ANY);
    }
}
