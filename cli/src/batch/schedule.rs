//! Scheduling of jobs on threads: large ones first, within a memory bound.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use crate::failure::Failure;
use crate::simplify::in_pool;

struct ScheduleState {
    /// Jobs with their costs, the largest last.
    waiting: Vec<(usize, u64)>,
    n_running: usize,
    running_cost: u64,
    failure: Option<Failure>,
}

/// Runs the jobs (number, cost), several at once while their costs sum to at most `bound`.
///
/// `n_threads` `None` means one thread per core. A job that costs more than half of `bound` runs alone on all threads.
///
/// # Errors
/// The first error of a job; no job starts after it.
pub fn run_jobs(
    costs: Vec<(usize, u64)>,
    bound: u64,
    n_threads: Option<usize>,
    work: &(impl Fn(usize) -> Result<(), Failure> + Sync),
) -> Result<(), Failure> {
    // Large jobs run one by one with all threads; next to others they would exceed the bound.
    let (large, mut small): (Vec<_>, Vec<_>) = costs.into_iter().partition(|&(_, cost)| cost > bound / 2);
    large.into_iter().try_for_each(|(job, _)| in_pool(n_threads, || work(job)))?;
    // The sort is stable, so equal jobs keep their order.
    small.reverse();
    small.sort_by_key(|&(_, cost)| cost);
    let n_threads = n_threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
    let n_workers = n_threads.min(small.len());
    let threads_each = n_threads / n_workers.max(1);
    let state = Mutex::new(ScheduleState { waiting: small, n_running: 0, running_cost: 0, failure: None });
    let changed = Condvar::new();
    std::thread::scope(|scope| {
        for _ in 0..n_workers {
            scope.spawn(|| {
                while let Some((job, cost)) = next_job(&state, &changed, bound) {
                    let result = in_pool(Some(threads_each), || work(job));
                    end_job(&state, cost, result);
                    changed.notify_all();
                }
            });
        }
    });
    lock_state(&state).failure.take().map_or(Ok(()), Err)
}

/// Waits for the largest job that fits under the bound with the running ones; `None` when none is left.
fn next_job(state: &Mutex<ScheduleState>, changed: &Condvar, bound: u64) -> Option<(usize, u64)> {
    let mut locked = lock_state(state);
    loop {
        if locked.waiting.is_empty() || locked.failure.is_some() {
            return None;
        }
        let room = bound.saturating_sub(locked.running_cost);
        let fits = locked.waiting.iter().rposition(|&(_, cost)| cost <= room);
        if let Some(at) = fits.or((locked.n_running == 0).then_some(0)) {
            let (job, cost) = locked.waiting.remove(at);
            locked.n_running += 1;
            locked.running_cost += cost;
            return Some((job, cost));
        }
        locked = changed.wait(locked).unwrap_or_else(PoisonError::into_inner);
    }
}

fn end_job(state: &Mutex<ScheduleState>, cost: u64, result: Result<(), Failure>) {
    let mut locked = lock_state(state);
    locked.n_running -= 1;
    locked.running_cost -= cost;
    if let Err(failure) = result {
        locked.failure.get_or_insert(failure);
    }
}

fn lock_state(state: &Mutex<ScheduleState>) -> MutexGuard<'_, ScheduleState> {
    state.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU64, Ordering};

    #[test]
    fn each_job_runs_once_and_within_the_bound() {
        let (taken, most) = (AtomicU64::new(0), AtomicU64::new(0));
        let done = Mutex::new(Vec::new());
        let costs: Vec<(usize, u64)> = (0..40).map(|i| (i, 1 + (i as u64 * 7) % 30)).collect();
        let cost = costs.clone();
        run_jobs(costs, 40, Some(8), &|i| {
            let own = cost[i].1;
            most.fetch_max(taken.fetch_add(own, Ordering::SeqCst) + own, Ordering::SeqCst);
            std::thread::sleep(std::time::Duration::from_millis(2));
            taken.fetch_sub(own, Ordering::SeqCst);
            done.lock().unwrap().push(i);
            Ok(())
        })
        .unwrap();
        let mut done = done.into_inner().unwrap();
        done.sort_unstable();
        assert_eq!(done, (0..40).collect::<Vec<_>>());
        assert!((21..=40).contains(&most.into_inner()));
    }

    #[test]
    fn no_job_starts_after_a_failure() {
        let begun = AtomicU64::new(0);
        let failed = run_jobs((0..100).map(|i| (i, 1)).collect(), 10, Some(2), &|_| {
            begun.fetch_add(1, Ordering::SeqCst);
            Err(Failure::Failed("the disk is full".into()))
        });
        assert!(failed.is_err() && begun.into_inner() <= 2);
    }
}
