//! Ctrl-C for work that ends cleanly, between two steps.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::failure::Failure;
use crate::messages::print_error;

static STOP_REQUESTED: AtomicBool = AtomicBool::new(false);

/// Handles Ctrl-C and termination: the first sets [`is_stop_requested`], the second ends the program.
pub fn handle_stop_signals() {
    let _ = ctrlc::set_handler(|| {
        // The second signal does not wait for a clean end.
        if STOP_REQUESTED.swap(true, Ordering::SeqCst) {
            print_error(&Failure::Stopped(
                "interrupted twice, without saving: continue from the last checkpoint with --resume".into(),
            ));
            std::process::exit(130);
        }
    });
}

/// Returns whether Ctrl-C or termination was received.
pub fn is_stop_requested() -> bool {
    STOP_REQUESTED.load(Ordering::SeqCst)
}
