//! The caller's functions in place of the system's allocator, in both libraries.
//!
//! The first allocation decides between the two for good, so each block is freed by what allocated it.
#![allow(unsafe_code, reason = "allocators are unsafe to implement")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::ffi::c_void;
use std::hint::spin_loop;
use std::mem::transmute;
use std::ptr::{copy_nonoverlapping, null_mut, write_bytes};
use std::sync::atomic::Ordering::{Acquire, Relaxed, Release};
use std::sync::atomic::{AtomicPtr, AtomicU8};

use crate::errors::{CallError, run_guarded};

type Allocate = extern "C" fn(usize) -> *mut c_void;
type Deallocate = extern "C" fn(*mut c_void);

/// Alignment in bytes of blocks from the caller, as `malloc` has it; blocks of a larger one are cut from longer blocks.
const ALIGNMENT: usize = 2 * size_of::<usize>();

/// Values of `CHOICE`.
mod choice {
    pub(super) const OPEN: u8 = 0;
    pub(super) const SYSTEM: u8 = 1;
    pub(super) const BEING_SET: u8 = 2;
    pub(super) const CALLER: u8 = 3;
}

static CHOICE: AtomicU8 = AtomicU8::new(choice::OPEN);
static ALLOCATE: AtomicPtr<()> = AtomicPtr::new(null_mut());
static DEALLOCATE: AtomicPtr<()> = AtomicPtr::new(null_mut());

/// Makes the library allocate by `allocate` and free by `deallocate`; returns 1, or 0 on failure.
///
/// To be called once, first: after any other call, or a refused one, the allocator is chosen. Blocks of `allocate` are
/// aligned as those of `malloc`; null ends the program. Both functions may be called from any thread, in any order, and as
/// long as a thread lives that has called the library.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub extern "C" fn nm_set_allocator(
    allocate: Option<extern "C" fn(size: usize) -> *mut c_void>,
    deallocate: Option<extern "C" fn(block: *mut c_void)>,
) -> i32 {
    run_guarded(0, || {
        let (Some(allocate), Some(deallocate)) = (allocate, deallocate) else {
            return Err(CallError::new("allocator", "a function is null"));
        };
        if CHOICE.compare_exchange(choice::OPEN, choice::BEING_SET, Acquire, Relaxed).is_err() {
            return Err(CallError::new("allocator", "the library has allocated: set it before all other calls"));
        }
        ALLOCATE.store(allocate as *mut (), Relaxed);
        DEALLOCATE.store(deallocate as *mut (), Relaxed);
        CHOICE.store(choice::CALLER, Release);
        Ok(1)
    })
}

// Whether the caller's functions allocate; decides it if it is open.
#[inline]
fn is_callers() -> bool {
    loop {
        match CHOICE.load(Acquire) {
            choice::SYSTEM => return false,
            choice::CALLER => return true,
            choice::OPEN => {
                let _ = CHOICE.compare_exchange(choice::OPEN, choice::SYSTEM, Acquire, Acquire);
            }
            _ => spin_loop(),
        }
    }
}

/// The allocator of the library.
struct ChosenAllocator;

#[global_allocator]
static ALLOCATOR: ChosenAllocator = ChosenAllocator;

// SAFETY: blocks of the system are the system's, with its own guarantees. Those of the caller are as long as asked for and aligned:
// by the caller up to `ALIGNMENT`, beyond by `allocate_by_caller`, which leaves room. `is_callers` never changes after the first block.
unsafe impl GlobalAlloc for ChosenAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if is_callers() { unsafe { allocate_by_caller(layout) } } else { unsafe { System.alloc(layout) } }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        if !is_callers() {
            return unsafe { System.alloc_zeroed(layout) };
        }
        let block = unsafe { allocate_by_caller(layout) };
        if !block.is_null() {
            unsafe { write_bytes(block, 0, layout.size()) };
        }
        block
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        if is_callers() { unsafe { free_by_caller(block, layout) } } else { unsafe { System.dealloc(block, layout) } }
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
        if !is_callers() {
            return unsafe { System.realloc(block, layout, new_size) };
        }
        let longer = unsafe { allocate_by_caller(Layout::from_size_align_unchecked(new_size, layout.align())) };
        if !longer.is_null() {
            unsafe { copy_nonoverlapping(block, longer, layout.size().min(new_size)) };
            unsafe { free_by_caller(block, layout) };
        }
        longer
    }
}

// A block with a larger alignment has the address of the caller's block in front of it.
unsafe fn allocate_by_caller(layout: Layout) -> *mut u8 {
    // SAFETY: the address was stored from a function of this type before `CHOICE` said so.
    let allocate: Allocate = unsafe { transmute(ALLOCATE.load(Relaxed)) };
    if layout.align() <= ALIGNMENT {
        return allocate(layout.size()).cast();
    }
    let whole: *mut u8 = allocate(layout.size() + layout.align()).cast();
    if whole.is_null() {
        return whole;
    }
    // SAFETY: the step is at least `ALIGNMENT`, at most the alignment, by which the whole block is longer.
    unsafe {
        let block = whole.add(layout.align() - whole.addr() % layout.align());
        block.cast::<*mut u8>().sub(1).write_unaligned(whole);
        block
    }
}

unsafe fn free_by_caller(block: *mut u8, layout: Layout) {
    // SAFETY: as in `allocate_by_caller`, which has written the address in front of the block.
    let deallocate: Deallocate = unsafe { transmute(DEALLOCATE.load(Relaxed)) };
    let is_cut = layout.align() > ALIGNMENT;
    deallocate(if is_cut { unsafe { block.cast::<*mut u8>().sub(1).read_unaligned() } } else { block }.cast());
}
