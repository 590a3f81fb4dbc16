//! Decompression of buffer views by meshoptimizer.

use meshopt::{
    decode_filter_color, decode_filter_exp, decode_filter_oct, decode_filter_quat, decode_index_buffer,
    decode_index_sequence, decode_vertex_buffer,
};

use serde::Deserialize;

use super::REMEDY;
use super::buffers::AssetBuffers;
use crate::io::ReadError;

/// Largest number of unpacked bytes: the first times the bytes of all buffers, plus the second.
const GROWTH: (usize, usize) = (64, 1 << 26);

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Compressed {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: usize,
    pub byte_length: usize,
    pub byte_stride: usize,
    pub count: usize,
    pub mode: String,
    pub filter: Option<String>,
}

pub(super) fn decompress(
    views: &[Option<&Compressed>],
    buffers: &AssetBuffers,
    _: &[String],
) -> Result<Vec<Option<Vec<u8>>>, ReadError> {
    let mut budget = GROWTH.0.saturating_mul(buffers.n_bytes()) + GROWTH.1;
    let mut decode = |(index, view): (usize, &Option<&Compressed>)| {
        let Some(view) = view else { return Ok(None) };
        let broken = || ReadError::file(format!("buffer view {index} cannot be decompressed"), REMEDY);
        // The claimed size may be anything, so it is checked before decoding.
        let size = view.count.checked_mul(view.byte_stride).filter(|&size| size <= budget).ok_or_else(broken)?;
        budget -= size;
        let bytes = buffers.get(view.buffer).and_then(|bytes| bytes.get(view.byte_offset..)?.get(..view.byte_length));
        bytes.and_then(|bytes| decode_view(view, bytes)).map(Some).ok_or_else(broken)
    };
    views.iter().enumerate().map(&mut decode).collect()
}

fn decode_view(view: &Compressed, bytes: &[u8]) -> Option<Vec<u8>> {
    let Compressed { count, byte_stride, .. } = *view;
    match (view.mode.as_str(), byte_stride) {
        // The format stores vertices in multiples of four bytes, up to 256.
        ("ATTRIBUTES", stride) if stride % 4 == 0 && stride > 0 => {
            let vertices = decode_vertices(bytes, count, stride)?;
            undo_filter(vertices, stride, view.filter.as_deref().unwrap_or("NONE"))
        }
        ("TRIANGLES", 2) if count % 3 == 0 => {
            Some(to_bytes(decode_index_buffer::<u16>(bytes, count).ok()?, u16::to_le_bytes))
        }
        ("TRIANGLES", 4) if count % 3 == 0 => {
            Some(to_bytes(decode_index_buffer::<u32>(bytes, count).ok()?, u32::to_le_bytes))
        }
        ("INDICES", 2) => Some(to_bytes(decode_index_sequence::<u16>(bytes, count).ok()?, u16::to_le_bytes)),
        ("INDICES", 4) => Some(to_bytes(decode_index_sequence::<u32>(bytes, count).ok()?, u32::to_le_bytes)),
        _ => None,
    }
}

// The Rust binding of meshoptimizer decodes into a type: a vertex of N words of 32 bits.
#[derive(Clone)]
struct Vertex<const N: usize>([u32; N]);

impl<const N: usize> Default for Vertex<N> {
    fn default() -> Self {
        Self([0; N])
    }
}

fn decode_vertices(bytes: &[u8], count: usize, stride: usize) -> Option<Vec<u8>> {
    macro_rules! of_words {
        ($($n:literal)*) => {
            match stride / 4 {
                $($n => vertices::<$n>(bytes, count),)*
                _ => None,
            }
        };
    }
    of_words!(1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32
        33 34 35 36 37 38 39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62 63 64)
}

fn vertices<const N: usize>(bytes: &[u8], count: usize) -> Option<Vec<u8>> {
    let vertices: Vec<Vertex<N>> = decode_vertex_buffer(bytes, count).ok()?;
    Some(vertices.into_iter().flat_map(|vertex| vertex.0).flat_map(u32::to_ne_bytes).collect())
}

fn undo_filter(bytes: Vec<u8>, stride: usize, filter: &str) -> Option<Vec<u8>> {
    match (filter, stride) {
        ("NONE", _) => Some(bytes),
        ("OCTAHEDRAL", 4) => Some(apply_filter(bytes, i8::from_le_bytes, i8::to_le_bytes, decode_filter_oct)),
        ("OCTAHEDRAL", 8) => Some(apply_filter(bytes, i16::from_le_bytes, i16::to_le_bytes, decode_filter_oct)),
        ("QUATERNION", 8) => Some(apply_filter(bytes, i16::from_le_bytes, i16::to_le_bytes, decode_filter_quat)),
        ("EXPONENTIAL", _) => Some(apply_filter(bytes, u32::from_le_bytes, u32::to_le_bytes, decode_filter_exp::<1>)),
        ("COLOR", 4) => Some(apply_filter(bytes, u8::from_le_bytes, u8::to_le_bytes, decode_filter_color)),
        ("COLOR", 8) => Some(apply_filter(bytes, u16::from_le_bytes, u16::to_le_bytes, decode_filter_color)),
        _ => None,
    }
}

fn apply_filter<C, const W: usize, const N: usize>(
    bytes: Vec<u8>,
    from: fn([u8; W]) -> C,
    to: fn(C) -> [u8; W],
    filter: fn(&mut [[C; N]]),
) -> Vec<u8> {
    let mut numbers: Vec<C> = bytes.as_chunks::<W>().0.iter().map(|&bytes| from(bytes)).collect();
    filter(numbers.as_chunks_mut::<N>().0);
    to_bytes(numbers, to)
}

fn to_bytes<C, const W: usize>(numbers: Vec<C>, to: fn(C) -> [u8; W]) -> Vec<u8> {
    numbers.into_iter().flat_map(to).collect()
}

#[cfg(test)]
mod tests {
    use meshopt::{encode_filter_oct, encode_index_buffer, encode_index_sequence, encode_vertex_buffer};

    use super::*;

    fn view(mode: &str, count: usize, byte_stride: usize, filter: Option<&str>) -> Compressed {
        let filter = filter.map(String::from);
        Compressed { buffer: 0, byte_offset: 0, byte_length: 0, byte_stride, count, mode: mode.into(), filter }
    }

    #[test]
    fn vertices_of_every_width_come_back() {
        for (stride, bytes) in [
            (4, encode_vertex_buffer(&[[1u8, 2, 3, 4], [5, 6, 7, 8]]).unwrap()),
            (8, encode_vertex_buffer(&[[1u8, 2, 3, 4, 5, 6, 7, 8]]).unwrap()),
        ] {
            let decoded = decode_view(&view("ATTRIBUTES", 8 / stride, stride, None), &bytes).unwrap();
            assert_eq!(decoded, [1, 2, 3, 4, 5, 6, 7, 8]);
        }
        let wide = [[7u32; 64]];
        let bytes = encode_vertex_buffer(&wide).unwrap();
        assert_eq!(decode_view(&view("ATTRIBUTES", 1, 256, None), &bytes).unwrap(), 7u32.to_le_bytes().repeat(64));
    }

    #[test]
    fn indices_come_back() {
        let indices = [0u32, 1, 2, 2, 1, 3];
        let triangles = encode_index_buffer(&indices, 4).unwrap();
        let sequence = encode_index_sequence(&indices, 4).unwrap();
        for (mode, bytes) in [("TRIANGLES", &triangles), ("INDICES", &sequence)] {
            let short = decode_view(&view(mode, 6, 2, None), bytes).unwrap();
            assert_eq!(short, indices.map(|i| (i as u16).to_le_bytes()).concat());
            let long = decode_view(&view(mode, 6, 4, None), bytes).unwrap();
            assert_eq!(long, indices.map(u32::to_le_bytes).concat());
        }
    }

    #[test]
    fn filters_are_undone() {
        let encoded: Vec<[i8; 4]> = encode_filter_oct(&[[0.0, 0.0, -1.0, 0.0], [1.0, 0.0, 0.0, 0.0]], 8);
        let bytes = encode_vertex_buffer(&encoded).unwrap();
        let found = decode_view(&view("ATTRIBUTES", 2, 4, Some("OCTAHEDRAL")), &bytes).unwrap();
        assert_eq!(found, [0, 0, 0x81, 0, 127, 0, 0, 0]);
        let halves = encode_vertex_buffer(&[(0xffu32 << 24) | 3, 5]).unwrap();
        let found = decode_view(&view("ATTRIBUTES", 2, 4, Some("EXPONENTIAL")), &halves).unwrap();
        assert_eq!(found, [1.5f32.to_le_bytes(), 5f32.to_le_bytes()].concat());
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let bytes = encode_vertex_buffer(&[1u32, 2, 3]).unwrap();
        for (mode, count, stride, filter) in [
            ("ATTRIBUTES", 3, 6, None),
            ("ATTRIBUTES", 3, 0, None),
            ("ATTRIBUTES", 3, 260, None),
            ("ATTRIBUTES", 3, 4, Some("QUATERNION")),
            ("ATTRIBUTES", 3, 4, Some("UNKNOWN")),
            ("ATTRIBUTES", 30_000, 4, None),
            ("TRIANGLES", 4, 4, None),
            ("TRIANGLES", 3, 1, None),
            ("INDICES", 3, 4, None),
            ("SOMETHING", 3, 4, None),
        ] {
            assert_eq!(
                decode_view(&view(mode, count, stride, filter), &bytes),
                None,
                "{mode} {count} {stride} {filter:?}"
            );
        }
    }
}
