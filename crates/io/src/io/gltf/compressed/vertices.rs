//! Decoder of vertex data: mode `ATTRIBUTES` of `EXT_meshopt_compression`, versions 0 and 1 of the format.
//!
//! A block of up to 256 vertices stores, byte by byte of the vertex, the differences from vertex to vertex in groups of 16.

use super::stream::{ByteStream, undo_zigzag};

const HEADER: u8 = 0xa0;
const GROUP: usize = 16;
const LARGEST_BLOCK: usize = 256;
const BLOCK_BYTES: usize = 8192;
// Bits of a difference by the two bits in the header of a group; version 1 has two sets.
const BITS: [[usize; 4]; 3] = [[0, 2, 4, 8], [0, 1, 2, 4], [1, 2, 4, 8]];

type BytePlanes = [[u8; LARGEST_BLOCK]; 4];

/// Decodes `count` vertices of `stride` bytes, a multiple of four up to 256; `None` for malformed data.
pub(super) fn decode_vertices(bytes: &[u8], count: usize, stride: usize) -> Option<Vec<u8>> {
    let mut data = ByteStream(bytes);
    let is_new = match data.take_byte()?.checked_sub(HEADER)? {
        0 => false,
        1 => true,
        _ => return None,
    };
    // The end holds the vertex before the first and the kind of each word, after padding.
    let tail = stride + if is_new { stride / 4 } else { 0 };
    let padded_tail = tail.max(if is_new { 24 } else { 32 });
    let start = data.0.len().checked_sub(padded_tail.max(tail))? + padded_tail - tail;
    let (first, kinds) = data.0[start..].split_at(stride);
    let mut last = first.to_vec();
    let mut vertices = vec![0; count * stride];
    let block = (BLOCK_BYTES / stride / GROUP * GROUP).min(LARGEST_BLOCK);
    for block in vertices.chunks_mut(block * stride) {
        decode_block(&mut data, block, &mut last, is_new.then_some(kinds))?;
    }
    (data.0.len() == padded_tail).then_some(vertices)
}

fn decode_block(data: &mut ByteStream, block: &mut [u8], last: &mut [u8], kinds: Option<&[u8]>) -> Option<()> {
    let stride = last.len();
    let n = block.len() / stride;
    let controls = if kinds.is_some() { data.take(stride / 4)? } else { &[] };
    let mut planes: BytePlanes = [[0; LARGEST_BLOCK]; 4];
    for word in 0..stride / 4 {
        for (at, plane) in planes.iter_mut().enumerate() {
            let control = controls.get(word).map(|control| control >> (2 * at) & 3);
            match control {
                None => decode_plane(data, &mut plane[..n.next_multiple_of(GROUP)], &BITS[0])?,
                Some(3) => plane[..n].copy_from_slice(data.take(n)?),
                Some(2) => plane[..n].fill(0),
                Some(set) => decode_plane(data, &mut plane[..n.next_multiple_of(GROUP)], &BITS[1 + usize::from(set)])?,
            }
        }
        let kind = kinds.map_or(0, |kinds| kinds[word]);
        add_differences(&planes, block, 4 * word, last, kind)?;
    }
    Some(())
}

fn decode_plane(data: &mut ByteStream, plane: &mut [u8], bits: &[usize; 4]) -> Option<()> {
    let (groups, _) = plane.as_chunks_mut::<GROUP>();
    let headers = data.take(groups.len().div_ceil(4))?;
    for (at, group) in groups.iter_mut().enumerate() {
        let bits = bits[usize::from(headers[at / 4] >> (2 * (at % 4)) & 3)];
        decode_group(data, bits, group)?;
    }
    Some(())
}

/// Decodes 16 numbers of 0, 1, 2, 4 or 8 bits; in place of the largest number, a whole byte follows them.
fn decode_group(data: &mut ByteStream, bits: usize, group: &mut [u8; GROUP]) -> Option<()> {
    match bits {
        0 => group.fill(0),
        8 => group.copy_from_slice(data.take(GROUP)?),
        _ => {
            let packed = data.take(bits * GROUP / 8)?;
            let (per_byte, largest) = (8 / bits, (1u8 << bits) - 1);
            for (at, number) in group.iter_mut().enumerate() {
                // Single bits begin at the lowest, wider numbers at the highest.
                let place = at % per_byte;
                let shift = if bits == 1 { place } else { 8 - bits * (place + 1) };
                let code = packed[at / per_byte] >> shift & largest;
                *number = if code == largest { data.take_byte()? } else { code };
            }
        }
    }
    Some(())
}

/// Adds the differences of one word of the vertices to the word of the vertex before.
fn add_differences(planes: &BytePlanes, block: &mut [u8], offset: usize, last: &mut [u8], kind: u8) -> Option<()> {
    let stride = last.len();
    let mut word = [0, 1, 2, 3].map(|at| last[offset + at]);
    let turn = u32::from(kind >> 4);
    for (vertex, target) in block.chunks_exact_mut(stride).enumerate() {
        let stored = [0, 1, 2, 3].map(|at: usize| planes[at][vertex]);
        word = match kind & 3 {
            0 => [0, 1, 2, 3].map(|at: usize| word[at].wrapping_add(undo_zigzag(stored[at].into()) as u8)),
            1 => {
                let half = |at: usize| {
                    let difference = undo_zigzag(u16::from_le_bytes([stored[at], stored[at + 1]]).into()) as u16;
                    u16::from_le_bytes([word[at], word[at + 1]]).wrapping_add(difference).to_le_bytes()
                };
                let ([a, b], [c, d]) = (half(0), half(2));
                [a, b, c, d]
            }
            2 => (u32::from_le_bytes(stored).rotate_right(turn) ^ u32::from_le_bytes(word)).to_le_bytes(),
            _ => return None,
        };
        target[offset..offset + 4].copy_from_slice(&word);
    }
    last[offset..offset + 4].copy_from_slice(&word);
    Some(())
}
