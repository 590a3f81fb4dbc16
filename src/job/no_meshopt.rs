//! Stub of `meshopt` for builds without it: rejects `--compress`.

use super::error::JobError;

pub fn check() -> Result<(), JobError> {
    let what = "--compress: this build lacks the feature meshopt: install with `cargo install --path cli --features meshopt`, or take --compress=quantize";
    Err(JobError::Options(what.into()))
}
