//! Detection of a standard output that was closed before the program started (Linux only).
//!
//! The check runs before Rust's runtime, which replaces a closed output by /dev/null without an error.

use std::sync::atomic::{AtomicBool, Ordering};

static CLOSED: AtomicBool = AtomicBool::new(false);

pub fn is_stdout_closed() -> bool {
    CLOSED.load(Ordering::Relaxed)
}

// Runs before Rust's runtime, which neither the two system calls nor the atomic flag need.
#[cfg(target_os = "linux")]
#[ctor::ctor(unsafe)]
fn detect_closed_stdout() {
    let is_there = |path: &str| std::fs::symlink_metadata(path).is_ok();
    CLOSED.store(is_there("/proc/self/fd") && !is_there("/proc/self/fd/1"), Ordering::Relaxed);
}
