//! Stub of compression for builds without `meshopt`.

/// Whether this build can compress.
pub(in crate::io::gltf) const CAN_COMPRESS: bool = false;

/// Returns the faces as they are.
pub(in crate::io::gltf) fn order_faces(faces: &[[u32; 3]], _: usize) -> Vec<[u32; 3]> {
    faces.to_vec()
}

/// Returns nothing.
pub(in crate::io::gltf) fn encode_octahedral(_: &[[f32; 4]]) -> Vec<u8> {
    Vec::new()
}

/// Returns nothing.
pub(super) fn compress_view(_: &[u8], _: bool, _: usize) -> Option<Vec<u8>> {
    None
}
