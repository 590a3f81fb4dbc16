//! Stub of `meshopt` for builds without it: rejects `--compress`.

use super::error::JobError;

pub fn check() -> Result<(), JobError> {
    Err(JobError::Feature { option: "--compress", feature: "meshopt" })
}
