//! Stub of `fbx` for builds without it.

use super::{ReadError, ReadMesh};
use crate::mesh::RawMesh;

pub(super) const CAN_READ: bool = false;

pub(super) fn read(_: &[u8]) -> Result<RawMesh, ReadError> {
    Err(ReadError::file("this build reads no FBX", "build with the feature fbx or convert the file"))
}

pub(super) fn read_attributed(bytes: &[u8]) -> Result<ReadMesh, ReadError> {
    read(bytes).map(|mesh| ReadMesh { mesh, ..ReadMesh::default() })
}
