//! How much memory there is, what the program does when it has no more, and what it keeps.

use std::cell::Cell;
use std::io::Write;
use std::path::PathBuf;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::SeqCst};

use neural_mesh::mesh::room::make_room;

use crate::{allocator, interrupt};

/// The largest block whose release tells glibc to keep blocks up to that size from then on, in bytes.
const LARGEST: usize = (32 << 20) - (1 << 16);
/// Meshes of a batch at once, at most, that are remembered by name when the memory is at an end.
const REMEMBERED: usize = 1024;
/// No mesh.
const NONE: usize = usize::MAX;

/// Lets large arrays take the places of freed ones. glibc returns each to the system until it has seen a larger one freed (`mallopt(3)`,
/// `M_MMAP_THRESHOLD`); this one is never touched, so it takes no memory. Elsewhere nothing changes.
pub fn keep_freed() {
    let mut block = Vec::<u8>::new();
    let _ = make_room(&mut block, LARGEST);
    drop(std::hint::black_box(block));
}

/// Bounds what the program takes by `gib`, or by what is free now.
pub fn bound(gib: Option<f64>) {
    let most = gib.map(bytes_of).or_else(free);
    most.into_iter().for_each(|most| allocator::bound(usize::try_from(most).unwrap_or(usize::MAX)));
}

/// So many GiB in bytes.
pub fn bytes_of(gib: f64) -> u64 {
    (gib * f64::from(1 << 30)) as u64
}

/// Bytes that programs can still have, with those on the disk, where the system says so (Linux).
fn free() -> Option<u64> {
    Some(available()? + kibibytes("SwapFree:").unwrap_or(0))
}

/// Bytes of memory that programs can still have, where the system says so (Linux).
pub fn available() -> Option<u64> {
    kibibytes("MemAvailable:")
}

fn kibibytes(name: &str) -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    line.trim().trim_end_matches("kB").trim().parse::<u64>().ok().map(|kib| 1024 * kib)
}

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
        "neural-mesh: out of memory: {n_bytes} bytes more are not to be had: give a smaller mesh, fewer --threads, or more --memory"
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
