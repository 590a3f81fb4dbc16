//! What stands for `--compress` in a build without the feature `meshopt`: a refusal.

use crate::failure::Failure;

/// Refuses.
pub fn check() -> Result<(), Failure> {
    let what = "--compress: this build lacks the feature meshopt: install with `cargo install --path cli --features meshopt`, or take --compress=quantize";
    Err(Failure::Usage(what.into()))
}
