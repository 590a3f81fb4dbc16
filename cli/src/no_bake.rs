//! What stands for `--bake` in a build without the feature `bake`: a refusal.

use neural_mesh::mesh::{Attributes, Looks, TriMesh};

use crate::dress::Dress;
use crate::failure::Failure;

/// Why nothing is baked.
const LACKS: &str =
    "--bake: this build lacks the feature bake: install with `cargo install --path cli --features bake`";

/// Refuses.
pub fn check(_: usize) -> Result<(), Failure> {
    Err(Failure::Usage(LACKS.into()))
}

/// Refuses, too.
pub fn dress(_: usize, _: bool, _: (&TriMesh, &Attributes, &Looks), _: &TriMesh) -> Result<Dress, String> {
    Err(LACKS.into())
}
