//! Lock that admits one batch at a time to a folder.

use std::fs::{File, TryLockError};
use std::path::Path;

use crate::failure::Failure;

/// Locks the folder until the returned file is dropped.
///
/// # Errors
/// If another batch holds the lock, or the disk does not support locks.
pub fn lock_folder(folder: &Path) -> Result<File, Failure> {
    let problem = |error| {
        Failure::in_file(folder, format!("cannot be locked against other batches: {error}: choose another folder"))
    };
    let file = open(folder).map_err(problem)?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(Failure::in_file(
            folder,
            "another batch writes into this folder: wait for its end, or choose another folder",
        )),
        Err(TryLockError::Error(error)) => Err(problem(error)),
    }
}

#[cfg(unix)]
fn open(folder: &Path) -> std::io::Result<File> {
    File::open(folder)
}

#[cfg(not(unix))]
fn open(folder: &Path) -> std::io::Result<File> {
    File::options().create(true).truncate(false).write(true).open(folder.join(LOCK_FILE))
}

pub const LOCK_FILE: &str = "manifest.lock";
