//! Whether standard output was closed when the program began. Rust's runtime opens /dev/null in its place, where all that is said
//! would be lost in silence, so this is seen before the runtime begins; on Linux alone, whose /proc tells.

use std::sync::atomic::{AtomicBool, Ordering};

static CLOSED: AtomicBool = AtomicBool::new(false);

/// Whether nothing that is said on standard output gets anywhere, because it was closed.
pub fn is_closed() -> bool {
    CLOSED.load(Ordering::Relaxed)
}

// Two system calls and a flag: nothing here needs the runtime, which is what the word in brackets vouches for.
#[cfg(target_os = "linux")]
#[ctor::ctor(unsafe)]
fn look() {
    let is_there = |path: &str| std::fs::symlink_metadata(path).is_ok();
    CLOSED.store(is_there("/proc/self/fd") && !is_there("/proc/self/fd/1"), Ordering::Relaxed);
}
