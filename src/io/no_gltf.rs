//! What stands for the glTF reader in a build without the feature `gltf`: a refusal.

use super::ReadError;
use crate::mesh::RawMesh;

/// Refuses every asset.
pub(super) fn read(_: &[u8], _: &dyn Fn(&str) -> Result<Vec<u8>, ReadError>) -> Result<RawMesh, ReadError> {
    Err(ReadError::file("this build reads no glTF", "build with the feature gltf or convert the file"))
}
