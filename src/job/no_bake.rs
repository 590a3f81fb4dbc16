//! What stands for `--bake` in a build without the feature `bake`: a refusal.

use crate::mesh::{Attributes, Looks, TriMesh};

use super::dress::Dress;
use super::error::JobError;

/// Why nothing is baked.
const LACKS: &str =
    "--bake: this build lacks the feature bake: install with `cargo install --path cli --features bake`";

/// Refuses.
pub fn check_size(_: usize) -> Result<(), JobError> {
    Err(JobError::Options(LACKS.into()))
}

/// Refuses, too.
pub fn dress(_: usize, _: bool, _: (&TriMesh, &Attributes, &Looks), _: &TriMesh) -> Result<Dress, String> {
    Err(LACKS.into())
}
