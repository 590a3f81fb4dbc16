//! Stub of `bake` for builds without it: rejects `--bake`.

use crate::mesh::{Attributes, Looks, TriMesh};

use super::baked_material::BakedMaterial;
use super::error::JobError;

pub fn check_size(_: usize) -> Result<(), JobError> {
    Err(JobError::Feature { option: "--bake", feature: "bake" })
}

pub fn bake_material(
    _: usize,
    _: bool,
    _: (&TriMesh, &Attributes, &Looks),
    _: &TriMesh,
) -> Result<BakedMaterial, String> {
    Err(JobError::Feature { option: "--bake", feature: "bake" }.to_string())
}
