//! What stands for `--compress` in a build without the feature `meshopt`: a refusal.

use super::error::JobError;

/// Refuses.
pub fn check() -> Result<(), JobError> {
    let what = "--compress: this build lacks the feature meshopt: install with `cargo install --path cli --features meshopt`, or take --compress=quantize";
    Err(JobError::Options(what.into()))
}
