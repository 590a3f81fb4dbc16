//! One batch at a time in a folder. The system frees the lock however the program ends.

use std::fs::{File, TryLockError};
use std::path::Path;

use crate::failure::Failure;

/// Holds the folder for this batch until the file is dropped.
///
/// # Errors
/// Where another batch holds it, or where the disk knows no locks.
pub fn lock(folder: &Path) -> Result<File, Failure> {
    let problem =
        |error| Failure::of(folder, format!("cannot be locked against other batches: {error}: choose another folder"));
    let held = open(folder).map_err(problem)?;
    match held.try_lock() {
        Ok(()) => Ok(held),
        Err(TryLockError::WouldBlock) => Err(Failure::of(
            folder,
            "another batch writes into this folder: wait for its end, or choose another folder",
        )),
        Err(TryLockError::Error(error)) => Err(problem(error)),
    }
}

/// The folder itself, which leaves nothing behind.
#[cfg(unix)]
fn open(folder: &Path) -> std::io::Result<File> {
    File::open(folder)
}

/// A file in it, where folders cannot be locked.
#[cfg(not(unix))]
fn open(folder: &Path) -> std::io::Result<File> {
    File::options().create(true).truncate(false).write(true).open(folder.join(NAME))
}

/// The name of that file.
pub const NAME: &str = "manifest.lock";
