//! Ctrl-C for work that ends cleanly, between two steps.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::failure::Failure;
use crate::words::complain;

static STOP: AtomicBool = AtomicBool::new(false);

/// Handles Ctrl-C and termination: the first sets [`is_stopping`], the second ends the program.
pub fn watch_for_a_good_end() {
    let _ = ctrlc::set_handler(|| {
        // The second signal does not wait for a clean end.
        if STOP.swap(true, Ordering::SeqCst) {
            complain(&Failure::Stopped("interrupted twice: continue with --resume".into()));
            std::process::exit(130);
        }
    });
}

/// Returns whether Ctrl-C or termination was received.
pub fn is_stopping() -> bool {
    STOP.load(Ordering::SeqCst)
}
