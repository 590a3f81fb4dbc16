//! Scheduling of jobs on threads within a memory bound.

use std::sync::{Mutex, PoisonError};

use crate::failure::Failure;
use crate::simplify::in_pool;

/// Runs the jobs (number, cost): cheap ones side by side, then each other one alone on all threads.
///
/// Costs of jobs that run at once sum to at most `bound`; `n_threads` `None` means one thread per core.
///
/// # Errors
/// The first error of a job; no job starts after it.
pub fn run_jobs(
    costs: Vec<(usize, u64)>,
    bound: u64,
    n_threads: Option<usize>,
    work: &(impl Fn(usize) -> Result<(), Failure> + Sync),
) -> Result<(), Failure> {
    let n_threads = n_threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
    let n_workers = n_threads.min(costs.len()).max(1);
    let (small, large): (Vec<_>, Vec<_>) = costs.into_iter().partition(|&(_, cost)| cost <= bound / n_workers as u64);
    // The jobs that wait, or the first error.
    let waiting = Mutex::new(Ok(small.into_iter()));
    let lock = || waiting.lock().unwrap_or_else(PoisonError::into_inner);
    let next_job = || lock().as_mut().ok().and_then(Iterator::next);
    let run_worker = || {
        while let Some((job, _)) = next_job() {
            if let Err(failure) = in_pool(Some(n_threads / n_workers), || work(job)) {
                let mut waiting = lock();
                *waiting = std::mem::replace(&mut *waiting, Ok(Vec::new().into_iter())).and(Err(failure));
            }
        }
    };
    std::thread::scope(|scope| (0..n_workers).for_each(|_| drop(scope.spawn(run_worker))));
    waiting.into_inner().unwrap_or_else(PoisonError::into_inner)?;
    large.into_iter().try_for_each(|(job, _)| in_pool(Some(n_threads), || work(job)))
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
        run_jobs(costs, 40, Some(4), &|i| {
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
