//! What stands for `--bake` in a build without the feature `bake`: a refusal.

use neural_mesh::simplify::Simplified;

use crate::dress::Dress;
use crate::failure::Failure;
use crate::request::Request;
use crate::subject::Subject;

/// Refuses.
pub fn check(_: usize) -> Result<(), Failure> {
    let what = "--bake: this build lacks the feature bake: install with `cargo install --path cli --features bake`";
    Err(Failure::Usage(what.into()))
}

/// Nothing is asked for that was not refused.
pub fn dress(_: &Request, _: &Subject, _: &Simplified) -> Result<Option<Dress>, Failure> {
    Ok(None)
}
