//! Decoders of indices: modes `TRIANGLES` and `INDICES` of `EXT_meshopt_compression`, versions 0 and 1 of the format.

use super::stream::{ByteStream, undo_zigzag};

const TRIANGLES_HEADER: u8 = 0xe0;
const SEQUENCE_HEADER: u8 = 0xd0;
const TRIANGLES_TAIL: usize = 16;
const SEQUENCE_TAIL: usize = 4;

/// The 16 latest entries, of which entry 0 is the latest.
struct Latest<T> {
    entries: [T; 16],
    next: usize,
}

impl<T: Copy> Latest<T> {
    fn push(&mut self, entry: T) {
        self.entries[self.next] = entry;
        self.next = (self.next + 1) & 15;
    }

    fn get(&self, at: usize) -> T {
        self.entries[self.next.wrapping_sub(1 + at) & 15]
    }
}

struct TriangleDecoder<'a> {
    // Numbers that the codes of the triangles call for.
    numbers: ByteStream<'a>,
    // Pairs of codes for frequent triangles that share no edge with a latest one.
    table: &'a [u8],
    edges: Latest<[u32; 2]>,
    vertices: Latest<u32>,
    // First index that no triangle has used.
    unused: u32,
    // Index that the next explicit one is relative to.
    last: u32,
    is_new: bool,
}

/// Decodes the `count` indices of triangles; `None` for malformed data.
pub(super) fn decode_triangles(bytes: &[u8], count: usize) -> Option<Vec<u32>> {
    let (&header, data) = bytes.split_first()?;
    let is_new = read_version(header, TRIANGLES_HEADER)?;
    let (data, table) = data.split_at(data.len().checked_sub(TRIANGLES_TAIL)?);
    let (codes, numbers) = data.split_at_checked(count / 3)?;
    let mut decoder = TriangleDecoder {
        numbers: ByteStream(numbers),
        table,
        edges: Latest { entries: [[u32::MAX; 2]; 16], next: 0 },
        vertices: Latest { entries: [u32::MAX; 16], next: 0 },
        unused: 0,
        last: 0,
        is_new,
    };
    let triangles: Vec<[u32; 3]> = codes.iter().map(|&code| decoder.decode(code)).collect::<Option<_>>()?;
    decoder.numbers.0.is_empty().then(|| triangles.into_flattened())
}

impl TriangleDecoder<'_> {
    fn decode(&mut self, code: u8) -> Option<[u32; 3]> {
        if code < 0xf0 { self.decode_beside_edge(code) } else { self.decode_alone(code) }
    }

    /// Decodes a triangle that shares one of the latest edges.
    fn decode_beside_edge(&mut self, code: u8) -> Option<[u32; 3]> {
        let [a, b] = self.edges.get(usize::from(code >> 4));
        let opposite = code & 15;
        let c = match opposite {
            0 => self.take_unused(),
            13 | 14 if self.is_new => {
                self.last = if opposite == 13 { self.last.wrapping_sub(1) } else { self.last.wrapping_add(1) };
                self.last
            }
            15 => self.take_explicit()?,
            _ => self.vertices.get(opposite.into()),
        };
        // A vertex that was among the latest does not move to the front.
        if opposite == 0 || opposite == 15 || self.is_new && opposite >= 13 {
            self.vertices.push(c);
        }
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        Some([a, b, c])
    }

    /// Decodes a triangle by the code of each of its vertices.
    fn decode_alone(&mut self, code: u8) -> Option<[u32; 3]> {
        let pair = if code < 0xfe { self.table[usize::from(code & 15)] } else { self.numbers.take_byte()? };
        if code >= 0xfe && pair == 0 {
            self.unused = 0;
        }
        let codes = [if code == 0xff { 15 } else { 0 }, pair >> 4, pair & 15];
        // The table of frequent pairs holds no explicit indices; there, 15 is one of the latest vertices.
        let is_explicit = codes.map(|vertex| vertex == 15 && code >= 0xfe);
        // All codes refer to the vertices before this triangle; explicit indices follow the codes.
        let mut triangle = [0; 3];
        for ((vertex, code), is_explicit) in triangle.iter_mut().zip(codes).zip(is_explicit) {
            *vertex = match code {
                _ if is_explicit => 0,
                0 => self.take_unused(),
                _ => self.vertices.get(usize::from(code) - 1),
            };
        }
        for (vertex, _) in triangle.iter_mut().zip(is_explicit).filter(|&(_, is_explicit)| is_explicit) {
            *vertex = self.take_explicit()?;
        }
        for ((vertex, code), is_explicit) in triangle.into_iter().zip(codes).zip(is_explicit) {
            if code == 0 || is_explicit {
                self.vertices.push(vertex);
            }
        }
        let [a, b, c] = triangle;
        for edge in [[b, a], [c, b], [a, c]] {
            self.edges.push(edge);
        }
        Some(triangle)
    }

    fn take_unused(&mut self) -> u32 {
        let index = self.unused;
        self.unused = index.wrapping_add(1);
        index
    }

    fn take_explicit(&mut self) -> Option<u32> {
        self.last = self.last.wrapping_add(undo_zigzag(self.numbers.take_number()?));
        Some(self.last)
    }
}

/// Decodes a sequence of `count` indices; `None` for malformed data.
pub(super) fn decode_sequence(bytes: &[u8], count: usize) -> Option<Vec<u32>> {
    let (&header, data) = bytes.split_first()?;
    read_version(header, SEQUENCE_HEADER)?;
    let end = data.len().checked_sub(SEQUENCE_TAIL)?;
    // Each index takes at least a byte.
    if count > end {
        return None;
    }
    let mut data = ByteStream(&data[..end]);
    // Each index is relative to the latest of one of two runs.
    let mut last = [0u32; 2];
    let mut take_index = || {
        let number = data.take_number()?;
        let run = &mut last[(number & 1) as usize];
        *run = run.wrapping_add(undo_zigzag(number >> 1));
        Some(*run)
    };
    let indices = (0..count).map(|_| take_index()).collect::<Option<_>>()?;
    data.0.is_empty().then_some(indices)
}

/// Returns whether the format has version 1 rather than 0.
fn read_version(header: u8, expected: u8) -> Option<bool> {
    (header & 0xf0 == expected && header & 15 <= 1).then_some(header & 15 == 1)
}
