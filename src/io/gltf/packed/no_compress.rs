//! What stands for compression in a build without the feature `meshopt`: nothing is compressed.

/// That it cannot be compressed here.
pub(in crate::io::gltf) const IS_HERE: bool = false;

/// The faces as they are.
pub(in crate::io::gltf) fn ordered(faces: &[[u32; 3]], _: usize) -> Vec<[u32; 3]> {
    faces.to_vec()
}

/// Nothing.
pub(in crate::io::gltf) fn octahedral(_: &[[f32; 4]]) -> Vec<u8> {
    Vec::new()
}

/// Nothing.
pub(super) fn compressed(_: &[u8], _: bool, _: usize) -> Option<Vec<u8>> {
    None
}
