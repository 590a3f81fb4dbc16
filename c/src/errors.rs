//! The last error of each thread, and a boundary that no panic crosses.

use std::cell::RefCell;
use std::ffi::{CString, c_char};
use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};

thread_local! {
    static LAST: RefCell<CString> = RefCell::default();
}

/// Why a call did nothing, in one line.
#[derive(Debug)]
pub struct Refused(pub String);

impl Refused {
    /// A refusal of an argument, by its name.
    pub fn of(argument: &str, what: impl Display) -> Self {
        Self(format!("{argument}: {what}"))
    }
}

impl<E: std::error::Error> From<E> for Refused {
    fn from(error: E) -> Self {
        Self(error.to_string())
    }
}

/// Does what a function is for; where that fails, keeps why and gives `failed`.
pub fn guarded<T>(failed: T, work: impl FnOnce() -> Result<T, Refused>) -> T {
    let what = match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(done)) => {
            keep("");
            return done;
        }
        Ok(Err(Refused(what))) => what,
        Err(_) => "internal error: please report it".into(),
    };
    keep(&what);
    failed
}

fn keep(what: &str) {
    let what = CString::new(what.replace('\0', " ")).unwrap_or_default();
    LAST.with_borrow_mut(|last| *last = what);
}

/// Returns why the last call of this thread failed, in one line of UTF-8; empty where it did not. The text is there until the next call of
/// this thread.
#[unsafe(no_mangle)]
pub extern "C" fn nm_last_error() -> *const c_char {
    LAST.with_borrow(|last| last.as_ptr())
}
