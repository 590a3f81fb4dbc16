//! Bound on the program's memory, and reuse of freed memory.

use std::borrow::Cow;
use std::path::Path;

use neural_mesh::io::Format;
use neural_mesh::mesh::fallible_allocation::make_room;

use crate::allocator;

const BASE_BYTES: u64 = 8 << 20;
/// Memory in bytes per texel while baking: two textures, each as image and as file.
const TEXEL_BYTES: u64 = 32;
/// Bound in bytes where the system does not report free memory.
const FALLBACK_BYTES: u64 = 4 << 30;
/// Size in bytes of the block whose release makes glibc keep blocks up to that size.
const RETAINED_BYTES: usize = (32 << 20) - (1 << 16);

/// Makes glibc reuse freed large arrays instead of returning them to the system (`mallopt(3)`, `M_MMAP_THRESHOLD`).
pub fn retain_freed_blocks() {
    let mut block = Vec::<u8>::new();
    let _ = make_room(&mut block, RETAINED_BYTES);
    drop(std::hint::black_box(block));
}

/// Bounds the memory of the program to `gib`, or to what is free now.
pub fn limit_memory(gib: Option<f64>) {
    // Where the system reports no free memory, the memory stays unbounded.
    let n_bytes = gib.map(gib_to_bytes).or_else(free_bytes);
    n_bytes.into_iter().for_each(|n_bytes| allocator::set_limit(usize::try_from(n_bytes).unwrap_or(usize::MAX)));
}

pub fn gib_to_bytes(gib: f64) -> u64 {
    (gib * f64::from(1 << 30)) as u64
}

/// Estimates the most memory of a run, in bytes, from the size of its file.
///
/// A face takes about 250 bytes in memory, and 20 (binary PLY, glTF) or 40 (STL, text) in files.
pub fn estimate_bytes(path: &Path, bake: Option<usize>) -> u64 {
    let bytes = std::fs::metadata(path).map_or(0, |found| found.len());
    let factor = match Format::from_path(path) {
        Some(Format::Ply | Format::Gltf | Format::Glb) => 14,
        _ => 7,
    };
    // Decompression makes meshes about five times larger, and the XML of 3MF ten times.
    let expansion = match (Format::without_gz(path), Format::from_path(path)) {
        (_, Some(Format::ThreeMf)) => 10,
        (Cow::Owned(_), _) => 5,
        _ => 1,
    };
    let textures = bake.map_or(0, |size| TEXEL_BYTES * (size as u64).pow(2));
    BASE_BYTES + factor * expansion * bytes + textures
}

fn free_bytes() -> Option<u64> {
    let meminfo = read_meminfo()?;
    Some(read_kibibytes(&meminfo, "MemAvailable:")? + read_kibibytes(&meminfo, "SwapFree:").unwrap_or(0))
}

pub fn available_bytes() -> Option<u64> {
    read_kibibytes(&read_meminfo()?, "MemAvailable:")
}

pub fn default_limit() -> u64 {
    available_bytes().unwrap_or(FALLBACK_BYTES) / 2
}

fn read_meminfo() -> Option<String> {
    std::fs::read_to_string("/proc/meminfo").ok()
}

fn read_kibibytes(meminfo: &str, name: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix(name))?;
    line.trim().trim_end_matches("kB").trim().parse::<u64>().ok().map(|kib| 1024 * kib)
}
