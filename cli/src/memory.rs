//! How much memory there is, how much of it the program may take, and what it keeps.

use neural_mesh::mesh::room::make_room;

use crate::allocator;

/// The largest block whose release tells glibc to keep blocks up to that size from then on, in bytes.
const LARGEST: usize = (32 << 20) - (1 << 16);

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
    let told = told()?;
    Some(kibibytes(&told, "MemAvailable:")? + kibibytes(&told, "SwapFree:").unwrap_or(0))
}

/// Bytes of memory that programs can still have, where the system says so (Linux).
pub fn available() -> Option<u64> {
    kibibytes(&told()?, "MemAvailable:")
}

/// What the system says of its memory.
fn told() -> Option<String> {
    std::fs::read_to_string("/proc/meminfo").ok()
}

/// A line of it in bytes.
fn kibibytes(told: &str, name: &str) -> Option<u64> {
    let line = told.lines().find_map(|line| line.strip_prefix(name))?;
    line.trim().trim_end_matches("kB").trim().parse::<u64>().ok().map(|kib| 1024 * kib)
}
