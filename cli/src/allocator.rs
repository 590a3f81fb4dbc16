//! System allocator with an upper bound.
//!
//! The only file of the program with `unsafe`, which allocators require.
#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::ptr::null_mut;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use neural_mesh::mesh::fallible_allocation::is_allocation_fallible;

/// Smallest counted block, in bytes: smaller ones take little next to a mesh's arrays.
const COUNTED: usize = 1 << 16;

/// Bytes in counted blocks.
static TAKEN: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(usize::MAX);
/// Handler that ends the program, given the unavailable number of bytes.
static END: OnceLock<fn(usize) -> !> = OnceLock::new();

/// Sets the handler for failed allocations; before, the standard library handles them.
pub fn end_by(end: fn(usize) -> !) {
    let _ = END.set(end);
}

pub fn bound(most: usize) {
    MOST.store(most, Relaxed);
}

pub fn most() -> usize {
    MOST.load(Relaxed)
}

/// System allocator with an upper bound; ends the program when memory runs out.
pub struct Bounded;

fn counted_size(size: usize) -> usize {
    if size < COUNTED { 0 } else { size }
}

/// Reserves `size` bytes and returns whether they fit under the bound.
fn take(size: usize) -> bool {
    let size = counted_size(size);
    let fits = size == 0 || TAKEN.fetch_add(size, Relaxed).saturating_add(size) <= most();
    if !fits {
        give(size);
    }
    fits
}

fn give(size: usize) {
    if counted_size(size) > 0 {
        TAKEN.fetch_sub(size, Relaxed);
    }
}

/// Returns a block from the system. Without one, returns null to callers that can handle it, else ends the program.
fn allocate(size: usize, from_system: impl FnOnce() -> *mut u8) -> *mut u8 {
    if take(size) {
        let block = from_system();
        if !block.is_null() {
            return block;
        }
        give(size);
    }
    match END.get() {
        Some(end) if !is_allocation_fallible() => end(size),
        _ => null_mut(),
    }
}

// SAFETY: every call is forwarded unchanged to the system's allocator, and so is its result; null means that nothing was
// allocated. A call that fails ends the process and never unwinds.
unsafe impl GlobalAlloc for Bounded {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        allocate(layout.size(), || unsafe { System.alloc(layout) })
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        allocate(layout.size(), || unsafe { System.alloc_zeroed(layout) })
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        unsafe { System.dealloc(block, layout) };
        give(layout.size());
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        give(layout.size());
        let moved = allocate(size, || unsafe { System.realloc(block, layout, size) });
        if moved.is_null() {
            // The old block stays valid when the move fails, so it counts again.
            TAKEN.fetch_add(counted_size(layout.size()), Relaxed);
        }
        moved
    }
}
