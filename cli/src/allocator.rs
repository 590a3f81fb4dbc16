//! The system's allocator with a bound on what the program takes, and an end in one line where no more is to be had.
//!
//! The one file of the program with `unsafe`: an allocator cannot do without. No block is looked into; each call goes to the system's
//! allocator as it came.
#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::ptr::null_mut;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use neural_mesh::mesh::fallible_allocation::is_allocation_fallible;

/// Smaller blocks are not counted: they are many, and take little beside the arrays of a mesh. In bytes.
const COUNTED: usize = 1 << 16;

/// Bytes in counted blocks, and how many there may be.
static TAKEN: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(usize::MAX);
/// What ends the program where so many bytes more are not to be had.
static END: OnceLock<fn(usize) -> !> = OnceLock::new();

/// Sets what ends the program where so many bytes more are not to be had; before that the standard library does.
pub fn end_by(end: fn(usize) -> !) {
    let _ = END.set(end);
}

/// From here on no more than so many bytes may be taken.
pub fn bound(most: usize) {
    MOST.store(most, Relaxed);
}

/// How many bytes may be taken.
pub fn most() -> usize {
    MOST.load(Relaxed)
}

/// The system's allocator, bounded.
pub struct Bounded;

fn counted(size: usize) -> usize {
    if size < COUNTED { 0 } else { size }
}

/// Whether a block of this size may be taken; then it is.
fn take(size: usize) -> bool {
    let size = counted(size);
    let fits = size == 0 || TAKEN.fetch_add(size, Relaxed).saturating_add(size) <= most();
    if !fits {
        give(size);
    }
    fits
}

fn give(size: usize) {
    if counted(size) > 0 {
        TAKEN.fetch_sub(size, Relaxed);
    }
}

/// A block of this size from the system, or null where the caller can go on without it; else the end of the program.
fn taken(size: usize, from_system: impl FnOnce() -> *mut u8) -> *mut u8 {
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

// SAFETY: each call is passed on with what it came with, and what comes back is passed back; null where nothing was taken. A call
// that cannot be met ends the process and never unwinds.
unsafe impl GlobalAlloc for Bounded {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        taken(layout.size(), || unsafe { System.alloc(layout) })
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        taken(layout.size(), || unsafe { System.alloc_zeroed(layout) })
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        unsafe { System.dealloc(block, layout) };
        give(layout.size());
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        give(layout.size());
        let moved = taken(size, || unsafe { System.realloc(block, layout, size) });
        if moved.is_null() {
            // The old block stays.
            TAKEN.fetch_add(counted(layout.size()), Relaxed);
        }
        moved
    }
}
