//! `--compress` in builds with the feature `meshopt`.

use super::error::JobError;

/// Accepts compression.
pub fn check() -> Result<(), JobError> {
    Ok(())
}
