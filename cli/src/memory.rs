//! Freed memory stays with the program: to get a page from the system again costs more than the arithmetic on what it holds.

/// The largest block whose release tells glibc to keep blocks up to that size from then on, in bytes.
const LARGEST: usize = (32 << 20) - (1 << 16);

/// Lets large arrays take the places of freed ones. glibc returns each to the system until it has seen a larger one freed (`mallopt(3)`,
/// `M_MMAP_THRESHOLD`); this one is never touched, so it takes no memory. Elsewhere nothing changes.
pub fn keep_freed() {
    drop(std::hint::black_box(Vec::<u8>::with_capacity(LARGEST)));
}
