//! How much memory there is, how much of it the program may take, and what it keeps.

use std::borrow::Cow;
use std::path::Path;

use neural_mesh::io::Format;
use neural_mesh::mesh::fallible_allocation::make_room;

use crate::allocator;

/// What a run takes whatever the mesh.
const BASE: u64 = 8 << 20;
/// Bytes for each texel that is baked: the texels themselves, and an image and its file for two textures at once.
const TEXEL: u64 = 32;
/// Bound where the system does not say how much memory is free.
const FALLBACK: u64 = 4 << 30;
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

/// About the most bytes that a run on the mesh takes, from above. A face takes 250 bytes there, and in a file 20 in binary
/// PLY and glTF, twice as many in STL and in text.
pub fn estimate(path: &Path, bake: Option<usize>) -> u64 {
    let bytes = std::fs::metadata(path).map_or(0, |found| found.len());
    let factor = match Format::from_path(path) {
        Some(Format::Ply | Format::Gltf | Format::Glb) => 14,
        _ => 7,
    };
    // Compressed meshes become about five times as long, the text of 3MF ten times.
    let packing = match (Format::without_gz(path), Format::from_path(path)) {
        (_, Some(Format::ThreeMf)) => 10,
        (Cow::Owned(_), _) => 5,
        _ => 1,
    };
    let textures = bake.map_or(0, |size| TEXEL * (size as u64).pow(2));
    BASE + factor * packing * bytes + textures
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

/// Half of what is free.
pub fn default_bound() -> u64 {
    available().unwrap_or(FALLBACK) / 2
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
