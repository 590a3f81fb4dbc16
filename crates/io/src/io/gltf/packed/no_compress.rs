//! Stub of compression for builds without `meshopt`.

pub(in crate::io::gltf) const CAN_COMPRESS: bool = false;

pub(in crate::io::gltf) fn order_faces(faces: &[[u32; 3]], _: usize) -> Vec<[u32; 3]> {
    faces.to_vec()
}

pub(in crate::io::gltf) fn encode_octahedral(_: &[[f32; 4]]) -> Vec<u8> {
    Vec::new()
}

pub(super) fn compress_view(_: &[u8], _: bool, _: usize) -> Option<Vec<u8>> {
    None
}
