//! What JavaScript calls, and what it is told meanwhile.
//!
//! JavaScript asks for `room`, writes a request there, calls `answer`, reads the answer at the address that it returns, `answer_length`
//! bytes, and is `done`. Memory may move in each call.
#![allow(unsafe_code, reason = "exported names and the imported function are unsafe to declare")]

use std::cell::RefCell;
use std::ops::ControlFlow;

use crate::answer::answer_to;

thread_local! {
    static ROOM: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static ANSWER: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
}

/// Makes room for a request of so many bytes. Returns its address, 0 where there is no memory.
#[unsafe(no_mangle)]
pub extern "C" fn room(n_bytes: usize) -> usize {
    ROOM.with_borrow_mut(|room| {
        room.clear();
        if room.try_reserve_exact(n_bytes).is_err() {
            return 0;
        }
        room.resize(n_bytes, 0);
        room.as_ptr().addr()
    })
}

/// Answers the request of so many bytes in the room. Returns the address of the answer.
#[unsafe(no_mangle)]
pub extern "C" fn answer(n_bytes: usize) -> usize {
    let mut request = ROOM.take();
    request.truncate(n_bytes);
    let answer = answer_to(&request, Box::new(tell));
    ANSWER.with_borrow_mut(|place| {
        *place = answer;
        place.as_ptr().addr()
    })
}

/// Returns the bytes of the answer.
#[unsafe(no_mangle)]
pub extern "C" fn answer_length() -> usize {
    ANSWER.with_borrow(Vec::len)
}

/// Gives room and answer back.
#[unsafe(no_mangle)]
pub extern "C" fn done() {
    drop(ROOM.take());
    drop(ANSWER.take());
}

#[cfg(target_arch = "wasm32")]
#[link(wasm_import_module = "env")]
unsafe extern "C" {
    safe fn progress(share: f64, part: u32) -> u32;
}

/// Nobody hears it outside of a browser.
#[cfg(not(target_arch = "wasm32"))]
fn progress(_: f64, _: u32) -> u32 {
    0
}

/// Tells how far a part of a run is; `Break` where JavaScript ends it.
fn tell(share: f64, part: u32) -> ControlFlow<()> {
    if progress(share, part) == 0 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
}
