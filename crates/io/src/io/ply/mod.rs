//! Stanford PLY, text and binary.

mod columns;
mod header;
mod pieces;
mod reader;
mod source;
mod write;

use std::sync::atomic::{AtomicUsize, Ordering};

use header::{Element, Encoding, Header};
pub(super) use pieces::PlyLayout;
use reader::PlyReader;
use source::Source;
pub(super) use write::write;

use super::extra::ReadMesh;
use super::memory::add_zeros;
use super::text::Text;
use super::{ReadError, Scalar};
use crate::mesh::RawMesh;
use crate::parallel;

const BLOCK: usize = 1 << 14;

pub(super) fn read(bytes: &[u8]) -> Result<RawMesh, ReadError> {
    Ok(PlyReader::read(bytes, Header::parse(bytes)?, false)?.mesh)
}

pub(super) fn read_attributed(bytes: &[u8]) -> Result<ReadMesh, ReadError> {
    let header = Header::parse(bytes)?;
    // Elements are found by name; a repeated name would mix up their attributes.
    let is_repeated = |name: &str| header.elements.iter().filter(|element| element.name == name).count() > 1;
    // Two tables of vertices would need their columns merged; such files are rare.
    if is_repeated("vertex") || is_repeated("face") {
        let notes = vec!["the file has two tables of vertices or of faces: only the geometry is kept".into()];
        return Ok(ReadMesh { notes, ..PlyReader::read(bytes, header, false)? });
    }
    PlyReader::read(bytes, header, true)
}

fn open<'a>(bytes: &'a [u8], header: &Header) -> Source<'a> {
    match header.encoding {
        Encoding::Text => {
            let text = Text::new(bytes).starting_at(header.body);
            // Rows without properties are no lines of the text.
            let elements = header.elements.iter().filter(|element| !element.properties.is_empty());
            let rows_left = elements.fold(0, |sum: usize, element| sum.saturating_add(element.count));
            Source::Text { text, rows_left, has_lines: None }
        }
        Encoding::LittleEndian => Source::Binary { bytes, at: header.body, big: false },
        Encoding::BigEndian => Source::Binary { bytes, at: header.body, big: true },
    }
}

fn records(bytes: &[u8], count: usize, stride: usize) -> Option<&[u8]> {
    bytes.get(..count.checked_mul(stride)?)
}

fn decode_positions(
    records: &[u8],
    stride: usize,
    scalars: [(usize, Scalar); 3],
    big: bool,
    positions: &mut [[f64; 3]],
) {
    let [x, y, z] = scalars;
    let record = |row: usize| &records[stride * row..][..stride];
    // Three consecutive little-endian floats are the usual layout.
    if !big && [x, y, z] == [(x.0, Scalar::F32), (x.0 + 4, Scalar::F32), (x.0 + 8, Scalar::F32)] {
        parallel::fill(positions, BLOCK, |row| {
            let (floats, _) = record(row)[x.0..x.0 + 12].as_chunks::<4>();
            std::array::from_fn(|axis| f64::from(f32::from_le_bytes(floats[axis])))
        });
    } else {
        let decode =
            |record: &[u8], (offset, scalar): (usize, Scalar)| scalar.decode(&record[offset..], big).unwrap_or(0.0);
        parallel::fill(positions, BLOCK, |row| scalars.map(|scalar| decode(record(row), scalar)));
    }
}

/// Reads faces after the first `n_before`, up to the first polygon; returns their number.
fn read_leading_triangles(
    source: &mut Source,
    element: &Element,
    n_before: usize,
    faces: &mut Vec<[u32; 3]>,
) -> Result<usize, ReadError> {
    let (Source::Binary { bytes, at, big }, [property]) = (source, element.properties.as_slice()) else { return Ok(0) };
    // Other layouts go through the loop over properties.
    // The usual layout has a count of one byte and indices of 32 bits.
    let usual = matches!(property.length, Some(Scalar::U8 | Scalar::I8));
    if !usual || !matches!(property.scalar, Scalar::I32 | Scalar::U32) {
        return Ok(0);
    }
    let (records, _) = bytes[*at..].as_chunks::<13>();
    let records = &records[..records.len().min(element.count - n_before)];
    // A polygon shifts all bytes after it, so the parallel part ends at the first one.
    let records = &records[..count_triangles(records)];
    let first = faces.len();
    add_zeros(faces, records.len())?;
    let decode = |bytes| if *big { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) };
    parallel::fill(&mut faces[first..], BLOCK, |row| {
        let (corners, _) = records[row][1..].as_chunks::<4>();
        std::array::from_fn(|corner| decode(corners[corner]))
    });
    *at += 13 * records.len();
    Ok(records.len())
}

/// Returns the number of records before the first that is no triangle.
fn count_triangles(records: &[[u8; 13]]) -> usize {
    let n = AtomicUsize::new(records.len());
    parallel::chunks(records, BLOCK, |block, records| {
        let start = block * BLOCK;
        // Blocks behind a polygon say nothing more.
        if start < n.load(Ordering::Relaxed) {
            let polygon = records.iter().position(|record| record[0] != 3);
            polygon.into_iter().for_each(|at| _ = n.fetch_min(start + at, Ordering::Relaxed));
        }
    });
    n.into_inner()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(bytes: &[u8]) -> String {
        read(bytes).unwrap_err().to_string()
    }

    #[test]
    fn any_layout_of_a_text() {
        let text = "ply\rformat ascii 1.0\rcomment element vertex 9\robj_info x\relement material 1\rproperty list uchar char name\r\
            property float shine\relement vertex 3\rproperty float64 z\rproperty list int float uv\rproperty uchar red\r\
            property short x\rproperty float y\relement nothing 4000000000\relement face 2\rproperty uchar flag\r\
            property list uint8 ushort vertex_index\rproperty list uchar float texcoord\rend_header\r\
            3 65 66 67 0.5\r1 0 255 0 0\r2 2 0.5 0.5 255 1 0\r3 1 7 255\r0 1\r7 3 0 1 2 1 0.5 1 2 2 0 0\r";
        let mesh = read(text.as_bytes()).unwrap();
        assert_eq!(mesh.positions, [[0.0, 0.0, 1.0], [1.0, 0.0, 2.0], [0.0, 1.0, 3.0]]);
        assert_eq!((mesh.faces, mesh.dropped_faces, mesh.double), (vec![[0, 1, 2]], 1, true));
    }

    #[test]
    fn what_a_row_has_beyond_the_header_is_passed_over() {
        let head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
            element face 2\nproperty list uchar int vertex_indices\nproperty uchar red\nend_header\n";
        let wanted = vec![[0, 1, 2], [2, 1, 0]];
        for rows in
            ["0 0 0\n1 0 0\n\n0 1 0 9 9\n3 0 1 2 9 1 1 1\n3 2 1 0 9 1 1\n", "0 0 0 1 0 0 0 1 0 3 0 1 2 9 3 2 1 0 9"]
        {
            let text = format!("{head}{rows}");
            assert_eq!(read(text.as_bytes()).unwrap().faces, wanted);
            assert_eq!(read_attributed(text.as_bytes()).unwrap().mesh.faces, wanted);
        }
    }

    #[test]
    fn triangle_strips() {
        let text = "ply\nformat ascii 1.0\nelement tristrips 1\nproperty list int int vertex_indices\nelement vertex 5\nproperty float x\n\
            property float y\nproperty float z\nend_header\n9 0 1 2 3 -1 2 3 4 4\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n";
        assert_eq!(read(text.as_bytes()).unwrap().faces, [[0, 1, 2], [2, 1, 3], [2, 3, 4]]);
    }

    #[test]
    fn line_ends_before_binary_values() {
        for end in ["\n", "\r\n", "\r"] {
            let lines = [
                "ply",
                "format binary_little_endian 1.0",
                "element vertex 1",
                "property uchar x",
                "property uchar y",
                "property uchar z",
                "end_header",
            ];
            let mut bytes = (lines.join(end) + end).into_bytes();
            bytes.extend(b"\n\r\n");
            assert_eq!(read(&bytes).unwrap().positions, [[10.0, 13.0, 10.0]], "{end:?}");
        }
    }

    #[test]
    fn counts_are_only_claims() {
        for encoding in ["ascii", "binary_little_endian", "binary_big_endian"] {
            let head = format!("ply\nformat {encoding} 1.0\n");
            let vertex = "element vertex 18446744073709551615\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 3 4 5 6 7";
            assert!(error(format!("{head}{vertex}").as_bytes()).contains("of 18446744073709551615"));
            let face = "element face 4294967295\nproperty list uint int vertex_indices\nend_header\n\u{7f}\u{7f}\u{7f}\u{7f} 1 2 3";
            assert!(error(format!("{head}{face}").as_bytes()).contains("no value for face 0"));
        }
    }

    #[test]
    fn what_is_missing_is_said() {
        let head = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n";
        for (text, expected) in [
            ("ply\nformat ascii 1.0\nelement vertex 1\n", "the header has no end"),
            ("plywood\n", "does not start with ply"),
            ("ply\nend_header\n", "does not name its encoding"),
            ("ply\nformat binary 1.0\n", "unknown encoding"),
            ("ply\nproperty float x\n", "before the first element"),
            ("ply\nelement vertex many\n", "needs a name and a count"),
            ("ply\nwhatever\n", "unknown word"),
            (&format!("{head}property list float x\n"), "needs a known type, like float or uchar, and a name"),
            (&format!("{head}end_header\n1\n"), "has no property y"),
            ("ply\nformat ascii 1.0\nelement face 1\nproperty int a\nend_header\n1\n", "has no list of vertex_indices"),
        ] {
            assert!(error(text.as_bytes()).contains(expected), "{text}: {}", error(text.as_bytes()));
        }
    }
}
