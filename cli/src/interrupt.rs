//! Handling of Ctrl-C: removes temporary files and ends with exit code 130.

use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::NamedTempFile;

use crate::failure::Failure;
use crate::messages::print_error;

static TEMPORARY: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Handles Ctrl-C and termination: they end the program with `ending`.
pub fn handle_signals(ending: Failure) {
    // A failure is ignored: where no handler can be set, the program works without one.
    let _ = ctrlc::set_handler(move || {
        // The lock on the list is held until the program ends, so that no file is moved into place any more.
        let files = lock_temporaries();
        for file in files.iter() {
            let _ = std::fs::remove_file(file);
        }
        print_error(&ending);
        std::process::exit(130);
    });
}

/// Removes the temporary files, unless another thread holds the list.
pub fn remove_temporaries() {
    let files = TEMPORARY.try_lock();
    files.iter().flat_map(|files| files.iter()).for_each(|file| drop(std::fs::remove_file(file)));
}

pub fn register_temporary(make: impl FnOnce() -> std::io::Result<NamedTempFile>) -> std::io::Result<NamedTempFile> {
    let mut files = lock_temporaries();
    let file = make()?;
    files.push(file.path().to_path_buf());
    Ok(file)
}

/// Runs `work`, delaying an interruption until it is done.
pub fn without_interruption<T>(work: impl FnOnce() -> T) -> T {
    let mut files = lock_temporaries();
    let result = work();
    // Files that `work` moved away leave the list; those of other threads still exist and stay in it.
    files.retain(|file| file.exists());
    result
}

fn lock_temporaries() -> MutexGuard<'static, Vec<PathBuf>> {
    TEMPORARY.lock().unwrap_or_else(PoisonError::into_inner)
}
