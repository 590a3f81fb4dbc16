//! Parallel removal of rows from arrays.

use crate::parallel;

const CHUNK: usize = 1 << 14;

pub(super) struct Compaction {
    /// Number of remaining rows before each row, and of all; n_rows + 1 entries.
    n_before: Vec<u32>,
}

impl Compaction {
    pub fn new(n: usize, is_kept: impl Fn(usize) -> bool + Sync) -> Self {
        let mut n_before = vec![0; n + 1];
        let count = |(task, counts): (usize, &mut [u32])| -> u32 {
            let mut n_left = 0;
            for (row, count) in (task * CHUNK..).zip(counts) {
                n_left += u32::from(is_kept(row));
                *count = n_left;
            }
            n_left
        };
        // Each task counts its own rows; the offsets of the tasks are added afterwards.
        let task_counts = parallel::each(n_before[1..].chunks_mut(CHUNK).enumerate(), count);
        let firsts: Vec<u32> = task_counts.iter().scan(0, |sum, n| Some(std::mem::replace(sum, *sum + n))).collect();
        let add = |(counts, first): (&mut [u32], u32)| counts.iter_mut().for_each(|count| *count += first);
        parallel::each(n_before[1..].chunks_mut(CHUNK).zip(firsts), add);
        Self { n_before }
    }

    pub fn len(&self) -> usize {
        self.n_before[self.n_before.len() - 1] as usize
    }

    /// Returns the new number of each row; for a removed row, that of the next remaining one.
    pub fn numbers(&self) -> &[u32] {
        &self.n_before
    }

    /// Moves the remaining rows to the front, each mapped by `change`.
    pub fn compact_rows<T: Copy + Send>(&self, rows: &mut [T], change: impl Fn(T) -> T + Sync) {
        // One range per thread: all rows but those of the first range move twice.
        let n_rows = rows.len().div_ceil(rayon::current_num_threads()).max(CHUNK);
        let compact_range = |task: usize, rows: &mut [T]| {
            let n_before = &self.n_before[task * n_rows..][..rows.len() + 1];
            for from in 0..rows.len() {
                if n_before[from] < n_before[from + 1] {
                    rows[(n_before[from] - n_before[0]) as usize] = change(rows[from]);
                }
            }
        };
        parallel::chunks_mut(rows, n_rows, compact_range);
        // Each task moved rows within its own range; now the ranges are joined.
        for from in (0..rows.len()).step_by(n_rows).skip(1) {
            let [to, end] = [from, rows.len().min(from + n_rows)].map(|row| self.n_before[row] as usize);
            rows.copy_within(from..from + end - to, to);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn remaining_rows_are_compacted_in_order() {
        for n in [0, 1, 7, CHUNK, CHUNK + 1, 5 * CHUNK + 3] {
            for is_kept in [|_| true, |_| false, |row: usize| row * row % 7 < 3, |row| row > CHUNK] {
                let left = Compaction::new(n, is_kept);
                let mut rows: Vec<usize> = (0..n).collect();
                left.compact_rows(&mut rows, |row| 2 * row);
                rows.truncate(left.len());
                assert_eq!(rows, (0..n).filter(|&row| is_kept(row)).map(|row| 2 * row).collect::<Vec<_>>());
                let moved = rows.iter().map(|row| left.numbers()[row / 2] as usize);
                assert!(moved.eq(0..rows.len()));
            }
        }
    }
}
