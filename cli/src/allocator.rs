//! System allocator with an upper bound on the program's memory.
//!
//! The only file of the program with `unsafe`, which allocators require.
#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::ptr::null_mut;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use neural_mesh::mesh::fallible_allocation::is_allocation_fallible;

/// Smallest counted block, in bytes: smaller ones take little next to a mesh's arrays.
const MIN_COUNTED_BYTES: usize = 1 << 16;

/// Bytes in counted blocks.
static RESERVED_BYTES: AtomicUsize = AtomicUsize::new(0);
static BYTE_LIMIT: AtomicUsize = AtomicUsize::new(usize::MAX);
/// Handler that ends the program, given the number of bytes that could not be allocated.
static OUT_OF_MEMORY_HANDLER: OnceLock<fn(usize) -> !> = OnceLock::new();

/// Sets the handler for failed allocations; before, the standard library handles them.
pub fn set_out_of_memory_handler(end: fn(usize) -> !) {
    let _ = OUT_OF_MEMORY_HANDLER.set(end);
}

pub fn set_limit(n_bytes: usize) {
    BYTE_LIMIT.store(n_bytes, Relaxed);
}

pub fn limit() -> usize {
    BYTE_LIMIT.load(Relaxed)
}

/// System allocator with an upper bound on the allocated bytes; ends the program when memory runs out.
pub struct BoundedAllocator;

fn counted_bytes(size: usize) -> usize {
    if size < MIN_COUNTED_BYTES { 0 } else { size }
}

/// Counts `size` bytes as used and returns whether they fit under the bound.
fn reserve(size: usize) -> bool {
    let size = counted_bytes(size);
    let fits = size == 0 || RESERVED_BYTES.fetch_add(size, Relaxed).saturating_add(size) <= limit();
    if !fits {
        release(size);
    }
    fits
}

fn release(size: usize) {
    if counted_bytes(size) > 0 {
        RESERVED_BYTES.fetch_sub(size, Relaxed);
    }
}

/// Returns a block from the system. Without one, returns null to callers that can handle it, else ends the program.
fn allocate(size: usize, from_system: impl FnOnce() -> *mut u8) -> *mut u8 {
    if reserve(size) {
        let block = from_system();
        if !block.is_null() {
            return block;
        }
        release(size);
    }
    match OUT_OF_MEMORY_HANDLER.get() {
        Some(end) if !is_allocation_fallible() => end(size),
        _ => null_mut(),
    }
}

// SAFETY: every call is forwarded unchanged to the system's allocator, and so is its result; null means that nothing was
// allocated. A call that fails ends the process and never unwinds.
unsafe impl GlobalAlloc for BoundedAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        allocate(layout.size(), || unsafe { System.alloc(layout) })
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        allocate(layout.size(), || unsafe { System.alloc_zeroed(layout) })
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        unsafe { System.dealloc(block, layout) };
        release(layout.size());
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        release(layout.size());
        let moved = allocate(size, || unsafe { System.realloc(block, layout, size) });
        if moved.is_null() {
            // The old block stays valid when the move fails, so it counts again.
            RESERVED_BYTES.fetch_add(counted_bytes(layout.size()), Relaxed);
        }
        moved
    }
}
