//! Ctrl-C: the temporary files go, the program ends with 130, and no result appears by half.

use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::NamedTempFile;

use crate::failure::Failure;
use crate::words::complain;

/// Files that must not stay when the program is interrupted.
static TEMPORARY: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Watches for Ctrl-C and termination from here on, to end the program with these words.
pub fn watch(ending: Failure) {
    // A system without signals is no reason not to simplify.
    let _ = ctrlc::set_handler(move || {
        // Held until the end: nothing is renamed into place any more.
        let files = held();
        for file in files.iter() {
            let _ = std::fs::remove_file(file);
        }
        complain(&ending);
        std::process::exit(130);
    });
}

/// Removes the temporary files, unless another thread is about to make or place one.
pub fn remove_temporaries() {
    let files = TEMPORARY.try_lock();
    files.iter().flat_map(|files| files.iter()).for_each(|file| drop(std::fs::remove_file(file)));
}

/// Makes a temporary file that goes if the program is interrupted.
pub fn with_temporary(make: impl FnOnce() -> std::io::Result<NamedTempFile>) -> std::io::Result<NamedTempFile> {
    let mut files = held();
    let file = make()?;
    files.push(file.path().to_path_buf());
    Ok(file)
}

/// Does something that an interruption comes before or after, not within.
pub fn uninterrupted<T>(work: impl FnOnce() -> T) -> T {
    let mut files = held();
    let result = work();
    // Those of other threads are still on their way.
    files.retain(|file| file.exists());
    result
}

fn held() -> MutexGuard<'static, Vec<PathBuf>> {
    TEMPORARY.lock().unwrap_or_else(PoisonError::into_inner)
}
