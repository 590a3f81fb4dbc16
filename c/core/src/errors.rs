//! Errors of calls; each thread keeps its last one, and no panic leaves the library.

use std::cell::RefCell;
use std::ffi::{CString, c_char};
use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};

thread_local! {
    static LAST_ERROR: RefCell<CString> = RefCell::default();
}

/// One-line reason why a call failed.
#[derive(Debug)]
pub struct CallError(pub String);

impl CallError {
    /// Makes the error of an argument, by its name and the reason.
    pub fn new(argument: &str, reason: impl Display) -> Self {
        Self(format!("{argument}: {reason}"))
    }
}

impl<E: std::error::Error> From<E> for CallError {
    fn from(error: E) -> Self {
        Self(error.to_string())
    }
}

/// Runs the body of a function; on an error or panic, sets the last error and returns `failed`.
pub fn run_guarded<T>(failed: T, body: impl FnOnce() -> Result<T, CallError>) -> T {
    let reason = match catch_unwind(AssertUnwindSafe(body)) {
        Ok(Ok(value)) => {
            set_last_error("");
            return value;
        }
        Ok(Err(CallError(reason))) => reason,
        Err(_) => "internal error: please report it".into(),
    };
    set_last_error(&reason);
    failed
}

fn set_last_error(reason: &str) {
    let reason = CString::new(reason.replace('\0', " ")).unwrap_or_default();
    LAST_ERROR.with_borrow_mut(|last| *last = reason);
}

/// Returns why this thread's last call failed, as one line of UTF-8; empty after success.
///
/// The text is valid until the next call of this thread.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub extern "C" fn nm_last_error() -> *const c_char {
    LAST_ERROR.with_borrow(|last| last.as_ptr())
}
