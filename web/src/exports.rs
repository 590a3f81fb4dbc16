//! The exported functions.
//!
//! JavaScript calls `allocate_request`, writes a request there, calls `answer`, reads `answer_length` bytes at the returned
//! address, and calls `free_messages`. Memory may move in each call.
#![allow(unsafe_code, reason = "exported names are unsafe to declare")]

use std::cell::RefCell;

use crate::answer::answer_to;
use crate::caller::report_progress;

thread_local! {
    static REQUEST: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static ANSWER: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
}

/// Allocates `n_bytes` bytes for a request; returns their address, or 0 without memory.
#[unsafe(no_mangle)]
pub extern "C" fn allocate_request(n_bytes: usize) -> usize {
    REQUEST.with_borrow_mut(|request| {
        request.clear();
        // JavaScript receives an error without memory, and no panic ends the module.
        if request.try_reserve_exact(n_bytes).is_err() {
            return 0;
        }
        request.resize(n_bytes, 0);
        request.as_ptr().addr()
    })
}

/// Answers the request of `n_bytes` bytes, and returns the address of the answer.
#[unsafe(no_mangle)]
pub extern "C" fn answer(n_bytes: usize) -> usize {
    let mut request = REQUEST.take();
    request.truncate(n_bytes);
    let answer = answer_to(&request, Box::new(report_progress));
    ANSWER.with_borrow_mut(|stored| {
        *stored = answer;
        stored.as_ptr().addr()
    })
}

/// Returns the number of bytes of the answer.
#[unsafe(no_mangle)]
pub extern "C" fn answer_length() -> usize {
    ANSWER.with_borrow(Vec::len)
}

/// Frees request and answer.
#[unsafe(no_mangle)]
pub extern "C" fn free_messages() {
    drop(REQUEST.take());
    drop(ANSWER.take());
}
