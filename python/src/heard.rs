//! Work in the background while Python listens: the GIL is let go, Ctrl-C and the progress callback are heard within a tenth of a
//! second, whatever the work is at.
//!
//! The thread that called waits, and looks up every few milliseconds: signals are Python's to handle, in that thread, and so is the
//! callback. Work that is not wanted any more is told so and left to end by itself; it holds nothing of Python's, and writes nothing
//! from then on. Pools of threads are kept for the next call, each for one call at a time; a forked process has its own, as threads of a
//! parent are not there in a child.

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

use crate::failure::{raised, refused};

/// How often the caller looks up.
pub const TICK: Duration = Duration::from_millis(20);
/// More threads than any machine has.
const MOST_THREADS: usize = 1024;
/// Pools that are kept.
const MOST_POOLS: usize = 8;

/// A pool of threads that waits for work.
struct Idle {
    /// The process that its threads are of.
    process: u32,
    n_threads: usize,
    pool: Arc<ThreadPool>,
}

static IDLE: Mutex<Vec<Idle>> = Mutex::new(Vec::new());

/// What the work tells, and is told.
#[derive(Clone)]
pub struct Ear {
    is_unwanted: Arc<AtomicBool>,
    /// How far it is, and at what.
    last: Arc<Mutex<(f32, &'static str)>>,
}

impl Ear {
    /// Who listens to a run.
    pub fn listener(&self) -> Box<Listener<'static>> {
        let ear = self.clone();
        Box::new(move |Event { total, stage, .. }| {
            *held(&ear.last) = (total, stage);
            ear.go_on()
        })
    }

    /// Whether the work is still wanted.
    pub fn go_on(&self) -> ControlFlow<()> {
        if self.is_unwanted.load(Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// What a mutex holds, whoever panicked with it.
pub fn held<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Does some work on a pool of so many threads, or of one per core, while `progress(done, stage)` is called at every look, also where
/// nothing has moved on: what it raises ends the work.
pub fn heard<T: Send + 'static>(
    py: Python,
    n_threads: Option<usize>,
    progress: Option<Bound<PyAny>>,
    work: impl FnOnce(&Ear) -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    if n_threads.is_some_and(|n| !(1..=MOST_THREADS).contains(&n)) {
        return Err(raised(&Failure::Usage(format!("threads: give a number from 1 to {MOST_THREADS}"))));
    }
    let n_threads = n_threads.unwrap_or(0);
    let pool = taken(n_threads);
    let pool = pool.map_err(|error| refused(format!("threads cannot be started: {error}: ask for fewer")))?;
    let (ear, (sender, receiver)) =
        (Ear { is_unwanted: Arc::default(), last: Arc::new(Mutex::new((0.0, "read"))) }, channel());
    let (of_work, back) = (ear.clone(), pool.clone());
    pool.spawn(move || {
        let done = catch_unwind(AssertUnwindSafe(|| work(&of_work)));
        kept(n_threads, back);
        // Whoever waited may be gone.
        drop(sender.send(done));
    });
    let done = waited(py, &Mutex::new(receiver), &ear, progress.as_ref());
    done.inspect_err(|_| ear.is_unwanted.store(true, Relaxed))
}

/// A pool of so many threads, or of one per core for 0, that waits, or else a new one.
fn taken(n_threads: usize) -> Result<Arc<ThreadPool>, ThreadPoolBuildError> {
    let process = std::process::id();
    let idle = idle().and_then(|mut idle| {
        let at = idle.iter().position(|idle| idle.process == process && idle.n_threads == n_threads)?;
        Some(idle.swap_remove(at).pool)
    });
    idle.map_or_else(|| ThreadPoolBuilder::new().num_threads(n_threads).build().map(Arc::new), Ok)
}

/// Keeps a pool for another call, where there is room.
fn kept(n_threads: usize, pool: Arc<ThreadPool>) {
    let process = std::process::id();
    if let Some(mut idle) = idle()
        && idle.iter().filter(|idle| idle.process == process).count() < MOST_POOLS
    {
        idle.push(Idle { process, n_threads, pool });
    }
}

/// The pools that wait; none in a child that was forked while another thread looked at them.
fn idle() -> Option<MutexGuard<'static, Vec<Idle>>> {
    match IDLE.try_lock() {
        Ok(idle) => Some(idle),
        Err(TryLockError::Poisoned(idle)) => Some(idle.into_inner()),
        Err(TryLockError::WouldBlock) => None,
    }
}

fn waited<T: Send>(
    py: Python,
    receiver: &Mutex<Receiver<Caught<Result<T, Failure>>>>,
    ear: &Ear,
    progress: Option<&Bound<PyAny>>,
) -> PyResult<T> {
    loop {
        match py.detach(|| held(receiver).recv_timeout(TICK)) {
            Ok(Ok(done)) => {
                let done = done.map_err(|failure| raised(&failure))?;
                progress.map_or(Ok(()), |progress| progress.call1((1.0, "done")).map(drop))?;
                return Ok(done);
            }
            Err(RecvTimeoutError::Timeout) => {
                py.check_signals()?;
                let (total, stage) = *held(&ear.last);
                progress.map_or(Ok(()), |progress| progress.call1((f64::from(total), stage)).map(drop))?;
            }
            Ok(Err(_)) | Err(RecvTimeoutError::Disconnected) => {
                return Err(refused("internal error: please report it"));
            }
        }
    }
}
