//! Compression by meshoptimizer, format version 0.

use meshopt::{encode_filter_oct, encode_index_buffer, encode_vertex_buffer_level, optimize_vertex_cache};

const DIRECTION_BITS: i32 = 8;
// Compression level; version 0 of the format has one method for all levels.
const LEVEL: i32 = 2;

pub(in crate::io::gltf) const CAN_COMPRESS: bool = true;

pub(in crate::io::gltf) fn order_faces(faces: &[[u32; 3]], n_vertices: usize) -> Vec<[u32; 3]> {
    optimize_vertex_cache(faces.as_flattened(), n_vertices).as_chunks::<3>().0.to_vec()
}

/// Encodes unit directions (n x 4) on an octahedron, four bytes each; rounds the fourth number.
pub(in crate::io::gltf) fn encode_octahedral(directions: &[[f32; 4]]) -> Vec<u8> {
    let encoded: Vec<[i8; 4]> = encode_filter_oct(directions, DIRECTION_BITS);
    encoded.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// Compresses a buffer view; `None` for an unsupported `stride`.
pub(super) fn compress_view(bytes: &[u8], is_triangles: bool, stride: usize) -> Option<Vec<u8>> {
    match (is_triangles, stride) {
        (true, 2) => {
            triangles(bytes.as_chunks::<2>().0.iter().map(|&index| u16::from_le_bytes(index).into()).collect())
        }
        (true, 4) => triangles(bytes.as_chunks::<4>().0.iter().map(|&index| u32::from_le_bytes(index)).collect()),
        (false, 4) => vertices::<4>(bytes),
        (false, 8) => vertices::<8>(bytes),
        (false, 12) => vertices::<12>(bytes),
        (false, 16) => vertices::<16>(bytes),
        (false, 64) => vertices::<64>(bytes),
        _ => None,
    }
}

fn triangles(indices: Vec<u32>) -> Option<Vec<u8>> {
    let n_vertices = indices.iter().max().map_or(0, |&most| most as usize + 1);
    encode_index_buffer(&indices, n_vertices).ok().filter(|bytes| !bytes.is_empty())
}

fn vertices<const N: usize>(bytes: &[u8]) -> Option<Vec<u8>> {
    encode_vertex_buffer_level(bytes.as_chunks::<N>().0, LEVEL, Some(0)).ok().filter(|bytes| !bytes.is_empty())
}
