//! Decompression of buffer views: `EXT_meshopt_compression` and its successor `KHR_meshopt_compression`.
//!
//! Written here since the crates that need no C++ do not serve: `meshopt-rs` lacks version 1 and decodes wrong quaternions,
//! `meshoptimizer-rs` takes 45 s to compile.

mod filters;
mod indices;
mod stream;
mod vertices;

use serde::Deserialize;

use super::buffers::AssetBuffers;
use super::refusals::REMEDY;
use crate::io::ReadError;
use filters::{undo_colours, undo_exponents, undo_octahedral, undo_quaternions};
use indices::{decode_sequence, decode_triangles};
use vertices::decode_vertices;

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
) -> Result<Vec<Option<Vec<u8>>>, ReadError> {
    let mut budget = GROWTH.0.saturating_mul(buffers.n_bytes()) + GROWTH.1;
    let mut decode = |(index, view): (usize, &Option<&Compressed>)| {
        let Some(view) = view else { return Ok(None) };
        let broken = || ReadError::file(format!("buffer view {index} cannot be decompressed"), REMEDY);
        // The claimed size may be anything, so it is checked before decoding.
        let size = view.count.checked_mul(view.byte_stride).filter(|&size| size <= budget).ok_or_else(broken)?;
        budget -= size;
        let bytes = buffers.part(view.buffer, view.byte_offset, view.byte_length);
        bytes.and_then(|bytes| decode_view(view, bytes)).map(Some).ok_or_else(broken)
    };
    views.iter().enumerate().map(&mut decode).collect()
}

fn decode_view(view: &Compressed, bytes: &[u8]) -> Option<Vec<u8>> {
    let Compressed { count, byte_stride, .. } = *view;
    match (view.mode.as_str(), byte_stride) {
        // The format stores vertices in multiples of four bytes, up to 256.
        ("ATTRIBUTES", stride) if stride % 4 == 0 && (4..=256).contains(&stride) => {
            let mut vertices = decode_vertices(bytes, count, stride)?;
            undo_filter(&mut vertices, stride, view.filter.as_deref().unwrap_or("NONE"))?;
            Some(vertices)
        }
        ("TRIANGLES", 2 | 4) if count % 3 == 0 => Some(store_indices(decode_triangles(bytes, count)?, byte_stride)),
        ("INDICES", 2 | 4) => Some(store_indices(decode_sequence(bytes, count)?, byte_stride)),
        _ => None,
    }
}

fn undo_filter(bytes: &mut [u8], stride: usize, filter: &str) -> Option<()> {
    match (filter, stride) {
        ("NONE", _) => {}
        ("OCTAHEDRAL", 4) => undo_octahedral::<1>(bytes),
        ("OCTAHEDRAL", 8) => undo_octahedral::<2>(bytes),
        ("QUATERNION", 8) => undo_quaternions(bytes),
        ("EXPONENTIAL", _) => undo_exponents(bytes),
        ("COLOR", 4) => undo_colours::<1>(bytes),
        ("COLOR", 8) => undo_colours::<2>(bytes),
        _ => return None,
    }
    Some(())
}

fn store_indices(indices: Vec<u32>, width: usize) -> Vec<u8> {
    match width {
        2 => indices.into_iter().flat_map(|index| (index as u16).to_le_bytes()).collect(),
        _ => indices.into_iter().flat_map(u32::to_le_bytes).collect(),
    }
}

#[cfg(feature = "meshopt")]
#[cfg(test)]
mod tests {
    use meshopt::{
        decode_filter_color, decode_filter_exp, decode_filter_oct, decode_filter_quat, decode_index_buffer,
        decode_index_sequence, decode_vertex_buffer, encode_filter_oct, encode_index_buffer, encode_index_sequence,
        encode_vertex_buffer, encode_vertex_buffer_level,
    };
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rand_xoshiro::rand_core::{Rng, SeedableRng};

    use super::*;

    fn view(mode: &str, count: usize, byte_stride: usize, filter: Option<&str>) -> Compressed {
        let filter = filter.map(String::from);
        Compressed { buffer: 0, byte_offset: 0, byte_length: 0, byte_stride, count, mode: mode.into(), filter }
    }

    // Numbers that grow, that repeat and that are anything, so that all encodings of differences occur.
    fn vertices<const N: usize>(count: usize, random: &mut impl Rng) -> Vec<[u32; N]> {
        let mut word = |vertex: usize, at: usize| match at % 4 {
            0 => (vertex as f32 * 0.1).to_bits(),
            1 => vertex as u32 / 3 * 0x0001_0201,
            2 => random.next_u32(),
            _ => random.next_u32() & 0x0100_0301,
        };
        (0..count).map(|vertex| std::array::from_fn(|at| word(vertex, at))).collect()
    }

    fn compare_vertices<const N: usize>(random: &mut Xoshiro256PlusPlus) {
        for count in [1, 15, 16, 17, 255, 256, 257, 1000] {
            let vertices = vertices::<N>(count, random);
            for (level, version) in [(0, Some(0)), (0, None), (1, None), (2, None), (3, None)] {
                let mut bytes = encode_vertex_buffer_level(&vertices, level, version).unwrap();
                for change in 0..20 {
                    // A vertex like [u32; N] is no `Default` for large N, so that words are compared.
                    let expected = match N {
                        1 => decode_vertex_buffer::<[u32; 1]>(&bytes, count).ok().map(|it| it.into_flattened()),
                        3 => decode_vertex_buffer::<[u32; 3]>(&bytes, count).ok().map(|it| it.into_flattened()),
                        _ => decode_vertex_buffer::<[u32; 16]>(&bytes, count).ok().map(|it| it.into_flattened()),
                    };
                    let found = decode_vertices(&bytes, count, 4 * N);
                    let expected = expected.map(|words| words.into_iter().flat_map(u32::to_le_bytes).collect());
                    assert_eq!(found, expected, "{N} words, {count} vertices, level {level}, {version:?}, {change}");
                    let n_bytes = bytes.len();
                    bytes[random.next_u32() as usize % n_bytes] ^= 1 << (random.next_u32() % 8);
                }
            }
        }
    }

    #[test]
    fn vertices_and_their_damage_are_read_as_by_the_reference() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
        compare_vertices::<1>(&mut random);
        compare_vertices::<3>(&mut random);
        compare_vertices::<16>(&mut random);
    }

    #[test]
    fn indices_and_their_damage_are_read_as_by_the_reference() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
        for n_faces in [1, 2, 100, 1000] {
            let strip = (0..n_faces).flat_map(|face| [face, face + 1 + face % 2, face + 2 - face % 2]);
            let wild = (0..3 * n_faces).map(|_| random.next_u32() % (n_faces + 2));
            for indices in [strip.collect::<Vec<u32>>(), wild.collect()] {
                let count = indices.len();
                let mut triangles = encode_index_buffer(&indices, n_faces as usize + 2).unwrap();
                let mut sequence = encode_index_sequence(&indices, n_faces as usize + 2).unwrap();
                for _ in 0..200 {
                    assert_eq!(decode_triangles(&triangles, count), decode_index_buffer(&triangles, count).ok());
                    assert_eq!(decode_sequence(&sequence, count), decode_index_sequence(&sequence, count).ok());
                    for bytes in [&mut triangles, &mut sequence] {
                        let n_bytes = bytes.len();
                        bytes[random.next_u32() as usize % n_bytes] ^= 1 << (random.next_u32() % 8);
                    }
                }
            }
        }
    }

    fn compare_filter<C, const W: usize, const N: usize>(
        undo: fn(&mut [u8]),
        reference: fn(&mut [[C; N]]),
        [from, to]: [fn([u8; W]) -> C; 2],
        numbers: &[u8],
        distance: fn(&C, &C) -> f64,
    ) {
        let mut found = numbers.to_vec();
        undo(&mut found);
        let read = |bytes: &[u8], from: fn([u8; W]) -> C| -> Vec<C> {
            bytes.as_chunks().0.iter().map(|&it| from(it)).collect()
        };
        let mut expected = read(numbers, from);
        reference(expected.as_chunks_mut().0);
        // The reference's vector instructions estimate roots and round ties to even.
        for (at, (found, expected)) in read(&found, to).iter().zip(&expected).enumerate() {
            assert!(distance(found, expected) <= 1.0, "number {at}");
        }
    }

    #[test]
    fn filters_are_undone_as_by_the_reference() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
        let mut bytes: Vec<u8> = (0..8000).map(|_| random.next_u32() as u8).collect();
        compare_filter(undo_exponents, decode_filter_exp::<1>, [u32::from_le_bytes; 2], &bytes, |a, b| {
            f64::from(*a != *b)
        });
        // Vectors and colours of the format, whose third number and alpha bound the others.
        let small = |bytes: &mut [u8], at: usize, bits: u32| bytes[at] &= (1 << bits) - 1;
        bytes.chunks_exact_mut(4).for_each(|it| (0..2).for_each(|at| it[at] = (it[at] as i8 / 2) as u8));
        bytes.chunks_exact_mut(4).for_each(|it| it[2] = 127);
        let apart = |a: &i8, b: &i8| (f64::from(*a) - f64::from(*b)).abs();
        compare_filter(undo_octahedral::<1>, decode_filter_oct, [i8::from_le_bytes; 2], &bytes, apart);
        bytes.chunks_exact_mut(4).for_each(|it| (it[1], it[2], it[3]) = (it[1] / 8, it[2] / 8, it[3] | 128));
        bytes.chunks_exact_mut(4).for_each(|it| it[0] = 64 + it[0] % 64);
        let apart = |a: &u8, b: &u8| (f64::from(*a) - f64::from(*b)).abs();
        compare_filter(undo_colours::<1>, decode_filter_color, [u8::from_le_bytes; 2], &bytes, apart);
        bytes.chunks_exact_mut(8).for_each(|it| (0..3).for_each(|at| small(it, 2 * at + 1, 6)));
        bytes.chunks_exact_mut(8).for_each(|it| (it[5], it[7]) = (127, 127));
        let apart = |a: &i16, b: &i16| (f64::from(*a) - f64::from(*b)).abs();
        compare_filter(undo_octahedral::<2>, decode_filter_oct, [i16::from_le_bytes; 2], &bytes, apart);
        bytes.chunks_exact_mut(8).for_each(|it| it[5] &= 63);
        compare_filter(undo_quaternions, decode_filter_quat, [i16::from_le_bytes; 2], &bytes, apart);
        let apart = |a: &u16, b: &u16| (f64::from(*a) - f64::from(*b)).abs();
        bytes.chunks_exact_mut(8).for_each(|it| (it[1], it[3], it[5], it[7]) = (64, it[3] / 4, it[5] / 4, 128));
        compare_filter(undo_colours::<2>, decode_filter_color, [u16::from_le_bytes; 2], &bytes, apart);
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
