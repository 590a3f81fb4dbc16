//! Stub of `bake` for builds without it: rejects `--bake`.

use crate::mesh::{Attributes, Looks, TriMesh};

use super::baked_material::BakedMaterial;
use super::error::JobError;

const LACKS: &str =
    "--bake: this build lacks the feature bake: install with `cargo install --path cli --features bake`";

pub fn check_size(_: usize) -> Result<(), JobError> {
    Err(JobError::Options(LACKS.into()))
}

pub fn bake_material(
    _: usize,
    _: bool,
    _: (&TriMesh, &Attributes, &Looks),
    _: &TriMesh,
) -> Result<BakedMaterial, String> {
    Err(LACKS.into())
}
