//! The end of the program where no more memory is to be had: one line, and in a batch the meshes that were under way.

use std::cell::Cell;
use std::io::Write;
use std::path::PathBuf;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::SeqCst};

use crate::{allocator, interrupt};

/// Meshes of a batch at once, at most, that are remembered by name when the memory is at an end.
const REMEMBERED: usize = 1024;
/// No mesh.
const NONE: usize = usize::MAX;

/// A batch as it is remembered when the memory is at an end.
struct Batch {
    /// Where its end is written down.
    path: PathBuf,
    /// The meshes as they are written down.
    names: Vec<String>,
}

static BATCH: OnceLock<Batch> = OnceLock::new();
static RUNNING: [AtomicUsize; REMEMBERED] = [const { AtomicUsize::new(NONE) }; REMEMBERED];

/// Has the meshes under way written to the file at `path` if the memory is at an end, a line each: how many they are, the bytes that
/// might be taken, and the one in `names`.
pub fn remember(path: PathBuf, names: Vec<String>) {
    let _ = BATCH.set(Batch { path, names });
}

/// Does the work on a mesh of the batch, by its number.
pub fn during<T>(mesh: usize, work: impl FnOnce() -> T) -> T {
    let is_free = |slot: &&AtomicUsize| slot.compare_exchange(NONE, mesh, SeqCst, SeqCst).is_ok();
    let slot = RUNNING.iter().find(is_free);
    let done = work();
    slot.into_iter().for_each(|slot| slot.store(NONE, SeqCst));
    done
}

/// Ends the program for want of memory, from within the allocator: in one line, with exit code 1.
pub fn end(n_bytes: usize) -> ! {
    thread_local! {
        static IS_ENDING: Cell<bool> = const { Cell::new(false) };
    }
    static ENDING: AtomicBool = AtomicBool::new(false);
    if IS_ENDING.replace(true) {
        // Not even the end has enough memory.
        std::process::abort();
    }
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
    write_down();
    std::process::exit(1);
}

/// Writes down the meshes that were under way.
fn write_down() {
    let Some(Batch { path, names }) = BATCH.get() else { return };
    let Ok(mut file) = std::fs::OpenOptions::new().create(true).append(true).open(path) else { return };
    let running = || RUNNING.iter().filter_map(|slot| names.get(slot.load(SeqCst)));
    for name in running() {
        let _ = writeln!(file, "{} {} {name}", running().count(), allocator::most());
    }
}
