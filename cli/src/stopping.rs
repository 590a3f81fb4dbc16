//! Ctrl-C for work that comes to a good end by itself: noted, and obeyed between two steps.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::failure::Failure;
use crate::words::complain;

/// Whether a long work was asked to stop.
static STOP: AtomicBool = AtomicBool::new(false);

/// Watches for Ctrl-C and termination from here on, for work that comes to a good end by itself: the first one is
/// noted for [`is_stopping`], the second ends the program.
pub fn watch_for_a_good_end() {
    let _ = ctrlc::set_handler(|| {
        if STOP.swap(true, Ordering::SeqCst) {
            complain(&Failure::Stopped("interrupted twice: continue with --resume".into()));
            std::process::exit(130);
        }
    });
}

/// Whether Ctrl-C or termination came.
pub fn is_stopping() -> bool {
    STOP.load(Ordering::SeqCst)
}
