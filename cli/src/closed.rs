//! Detection of a standard output that was closed before the program started (Linux only).
//!
//! Rust's runtime opens /dev/null in its place, which hides all output without an error. So this looks before the runtime starts.

use std::sync::atomic::{AtomicBool, Ordering};

static CLOSED: AtomicBool = AtomicBool::new(false);

/// Returns whether standard output was closed when the program started.
pub fn is_closed() -> bool {
    CLOSED.load(Ordering::Relaxed)
}

// Runs before the runtime: two system calls and an atomic flag need nothing of it.
#[cfg(target_os = "linux")]
#[ctor::ctor(unsafe)]
fn look() {
    let is_there = |path: &str| std::fs::symlink_metadata(path).is_ok();
    CLOSED.store(is_there("/proc/self/fd") && !is_there("/proc/self/fd/1"), Ordering::Relaxed);
}
