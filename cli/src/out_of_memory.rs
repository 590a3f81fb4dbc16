//! End of the program when memory runs out, with a record of the meshes in progress.

use std::cell::Cell;
use std::io::Write;
use std::path::PathBuf;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::SeqCst};

use crate::interrupt;

const MAX_RUNNING: usize = 1024;
const NO_MESH: usize = usize::MAX;

struct RecordedBatch {
    path: PathBuf,
    names: Vec<String>,
}

static BATCH: OnceLock<RecordedBatch> = OnceLock::new();
static RUNNING: [AtomicUsize; MAX_RUNNING] = [const { AtomicUsize::new(NO_MESH) }; MAX_RUNNING];

/// Registers a batch: when memory runs out, the names of the meshes in progress are appended to `path`, one per line.
pub fn register_batch(path: PathBuf, names: Vec<String>) {
    let _ = BATCH.set(RecordedBatch { path, names });
}

pub fn track_mesh<T>(mesh: usize, work: impl FnOnce() -> T) -> T {
    let is_free = |slot: &&AtomicUsize| slot.compare_exchange(NO_MESH, mesh, SeqCst, SeqCst).is_ok();
    let slot = RUNNING.iter().find(is_free);
    let result = work();
    slot.into_iter().for_each(|slot| slot.store(NO_MESH, SeqCst));
    result
}

/// Ends the program from within the allocator, with one line and exit code 1.
pub fn end_program(n_bytes: usize) -> ! {
    thread_local! {
        static IS_ENDING: Cell<bool> = const { Cell::new(false) };
    }
    static ENDING: AtomicBool = AtomicBool::new(false);
    if IS_ENDING.replace(true) {
        // The ending itself ran out of memory.
        std::process::abort();
    }
    // One thread ends the program; the others wait for it.
    if ENDING.swap(true, SeqCst) {
        loop {
            std::thread::park();
        }
    }
    let _ = writeln!(
        std::io::stderr(),
        "neural-mesh: out of memory: {n_bytes} more bytes are not available: use a smaller mesh, fewer --threads, or more --memory"
    );
    interrupt::remove_temporaries();
    record_running_meshes();
    std::process::exit(1);
}

fn record_running_meshes() {
    let Some(RecordedBatch { path, names }) = BATCH.get() else { return };
    let Ok(mut file) = std::fs::OpenOptions::new().create(true).append(true).open(path) else { return };
    for name in RUNNING.iter().filter_map(|slot| names.get(slot.load(SeqCst))) {
        let _ = writeln!(file, "{name}");
    }
}
