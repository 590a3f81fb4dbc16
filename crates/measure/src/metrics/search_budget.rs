//! Work limits for measurements.

use crate::parallel;

const PROBES: usize = 64;
const ROUND: [u64; 2] = [64, 16_384];

/// Returns how many of `n` searches fit a budget of `most` visits, estimated from the visits of a few.
pub(super) fn affordable_count(n: usize, most: f64, looks: impl Fn(usize) -> u32) -> usize {
    let n_probes = PROBES.min(n);
    let each = (0..n_probes).map(|i| looks(i * n / n_probes)).map(f64::from).sum::<f64>() / n_probes as f64;
    ((most / each.max(1.0)) as usize).clamp(n_probes, n)
}

/// Runs `find` for `n` items in parallel; `None` once the sum of the costs it returns exceeds `most`.
pub(super) fn run_within_budget<T: Send>(
    n: usize,
    most: u64,
    find: impl Fn(usize) -> (T, u64) + Sync,
) -> Option<Vec<T>> {
    let mut all = Vec::with_capacity(n);
    let (mut looks, mut most_of_one) = (0, 1);
    while all.len() < n {
        let affordable_count = (most - looks) / (2 * most_of_one);
        let round = if all.is_empty() { ROUND[0] } else { affordable_count.clamp(ROUND[0], ROUND[1]) };
        let first = all.len();
        for (found, looked) in parallel::map((n - first).min(round as usize), 1, |i| find(first + i)) {
            (looks, most_of_one) = (looks + looked, most_of_one.max(looked));
            all.push(found);
        }
        if looks > most {
            return None;
        }
    }
    Some(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU64, Ordering};

    #[test]
    fn what_costs_too_much_is_left_out_soon() {
        assert_eq!(affordable_count(1000, 1e6, |_| 20), 1000);
        assert_eq!(affordable_count(1000, 1e6, |_| 5000), 200);
        assert_eq!(affordable_count(1000, 1e6, |_| u32::MAX), PROBES);
        assert_eq!(affordable_count(10, 1.0, |_| 5000), 10);
        let looked = AtomicU64::new(0);
        let find = |each: u64| {
            let looked = &looked;
            move |i: usize| {
                looked.fetch_add(each, Ordering::Relaxed);
                (i, each)
            }
        };
        assert_eq!(run_within_budget(50_000, 1_000_000, find(20)), Some((0..50_000).collect()));
        looked.store(0, Ordering::Relaxed);
        assert_eq!(run_within_budget(50_000, 1_000_000, find(500)), None);
        assert!(looked.load(Ordering::Relaxed) <= 1_000_000 + 500 * ROUND[0], "{looked:?}");
        assert_eq!(run_within_budget(0, 0, find(1)), Some(Vec::new()));
    }
}
