//! Background work that leaves Python responsive: the GIL is released, signals and callbacks are handled.
//!
//! The calling thread wakes every few milliseconds, since Python allows signal handling only there. Cancelled work ends
//! by itself. A forked process has its own pools, since threads do not survive a fork.

use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};
use std::thread::Result as Caught;
use std::time::Duration;

use neural_mesh::simplify::{Event, Listener};
use neural_mesh_cli::embedded::Failure;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

use crate::failure::{invalid_array, to_exception};

/// Time between two checks for signals and progress.
pub const TICK: Duration = Duration::from_millis(20);
const MAX_THREADS: usize = 1024;
/// Largest number of idle pools per process.
const MAX_POOLS: usize = 8;

struct IdlePool {
    /// Id of the process that started the pool's threads.
    process: u32,
    n_threads: usize,
    pool: Arc<ThreadPool>,
}

static IDLE_POOLS: Mutex<Vec<IdlePool>> = Mutex::new(Vec::new());

/// Progress of the work and its caller's request to stop, shared by both.
#[derive(Clone)]
pub struct ProgressChannel {
    is_cancelled: Arc<AtomicBool>,
    last: Arc<Mutex<(f32, &'static str)>>,
}

impl ProgressChannel {
    pub fn listener(&self) -> Box<Listener<'static>> {
        let channel = self.clone();
        Box::new(move |Event { total, stage, .. }| channel.hear(total, stage))
    }

    /// Keeps the share that is done for the caller, and tells whether to go on.
    pub fn hear(&self, total: f32, stage: &'static str) -> ControlFlow<()> {
        *lock(&self.last) = (total, stage);
        self.check_cancelled()
    }

    pub fn check_cancelled(&self) -> ControlFlow<()> {
        if self.is_cancelled.load(Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

pub fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Runs `work` on `n_threads` threads, or one per core, and calls `progress(done, stage)` every [`TICK`].
///
/// An exception in `progress` stops the work.
pub fn run_in_background<T: Send + 'static>(
    py: Python,
    n_threads: Option<usize>,
    progress: Option<Bound<PyAny>>,
    work: impl FnOnce(&ProgressChannel) -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    if n_threads.is_some_and(|n| !(1..=MAX_THREADS).contains(&n)) {
        return Err(to_exception(&Failure::Usage(format!("threads: give a number from 1 to {MAX_THREADS}"))));
    }
    let n_threads = n_threads.unwrap_or(0);
    let pool = take_pool(n_threads);
    let pool = pool.map_err(|error| invalid_array(format!("threads cannot be started: {error}: use fewer threads")))?;
    let (channel, (sender, receiver)) =
        (ProgressChannel { is_cancelled: Arc::default(), last: Arc::new(Mutex::new((0.0, "read"))) }, channel());
    let (channel_of_work, pool_of_work) = (channel.clone(), pool.clone());
    pool.spawn(move || {
        let done = catch_unwind(AssertUnwindSafe(|| work(&channel_of_work)));
        keep_pool(n_threads, pool_of_work);
        // The caller may have stopped waiting.
        drop(sender.send(done));
    });
    let done = wait_for_work(py, &Mutex::new(receiver), &channel, progress.as_ref());
    done.inspect_err(|_| channel.is_cancelled.store(true, Relaxed))
}

/// Returns an idle pool of `n_threads` threads, or a new one; 0 means one per core.
fn take_pool(n_threads: usize) -> Result<Arc<ThreadPool>, ThreadPoolBuildError> {
    let process = std::process::id();
    // Threads do not survive a fork, so a forked process ignores the pools of its parent.
    let idle = lock_idle_pools().and_then(|mut idle| {
        let at = idle.iter().position(|idle| idle.process == process && idle.n_threads == n_threads)?;
        Some(idle.swap_remove(at).pool)
    });
    idle.map_or_else(|| ThreadPoolBuilder::new().num_threads(n_threads).build().map(Arc::new), Ok)
}

fn keep_pool(n_threads: usize, pool: Arc<ThreadPool>) {
    let process = std::process::id();
    if let Some(mut idle) = lock_idle_pools()
        && idle.iter().filter(|idle| idle.process == process).count() < MAX_POOLS
    {
        idle.push(IdlePool { process, n_threads, pool });
    }
}

/// Locks the idle pools; `None` in a child that was forked while the pools were locked.
fn lock_idle_pools() -> Option<MutexGuard<'static, Vec<IdlePool>>> {
    match IDLE_POOLS.try_lock() {
        Ok(idle) => Some(idle),
        Err(TryLockError::Poisoned(idle)) => Some(idle.into_inner()),
        Err(TryLockError::WouldBlock) => None,
    }
}

fn wait_for_work<T: Send>(
    py: Python,
    receiver: &Mutex<Receiver<Caught<Result<T, Failure>>>>,
    channel: &ProgressChannel,
    progress: Option<&Bound<PyAny>>,
) -> PyResult<T> {
    loop {
        match py.detach(|| lock(receiver).recv_timeout(TICK)) {
            Ok(Ok(done)) => {
                let done = done.map_err(|failure| to_exception(&failure))?;
                progress.map_or(Ok(()), |progress| progress.call1((1.0, "done")).map(drop))?;
                return Ok(done);
            }
            Err(RecvTimeoutError::Timeout) => {
                py.check_signals()?;
                let (total, stage) = *lock(&channel.last);
                progress.map_or(Ok(()), |progress| progress.call1((f64::from(total), stage)).map(drop))?;
            }
            Ok(Err(_)) | Err(RecvTimeoutError::Disconnected) => {
                return Err(invalid_array("internal error: please report it"));
            }
        }
    }
}
