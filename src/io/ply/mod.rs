//! Stanford PLY, text and binary.

mod attributed;
mod columns;
pub(super) mod header;
mod source;
mod write;

use rayon::prelude::*;

use header::{Element, Encoding, Header};
use source::Source;
pub(super) use write::write;

use super::extra::{Extra, ReadMesh};
use super::memory::reserve;
use super::text::Text;
use super::{ReadError, Scalar};
use crate::mesh::{Fans, RawMesh};

const BLOCK: usize = 1 << 14;

pub(super) fn read(bytes: &[u8]) -> Result<RawMesh, ReadError> {
    read_geometry(bytes, &Header::parse(bytes)?)
}

pub(super) fn read_attributed(bytes: &[u8]) -> Result<ReadMesh, ReadError> {
    let header = Header::parse(bytes)?;
    // Elements are found by name; a repeated name would mix up their attributes.
    let is_repeated = |name: &str| header.elements.iter().filter(|element| element.name == name).count() > 1;
    // Two tables of vertices would need their columns merged; such files are rare.
    if is_repeated("vertex") || is_repeated("face") {
        let mesh = read_geometry(bytes, &header)?;
        let notes = vec!["the file has two tables of vertices or of faces: only the geometry is kept".into()];
        let extra = Extra { comments: header.comments, ..Extra::default() };
        return Ok(ReadMesh { mesh, extra, notes, format: None });
    }
    attributed::read(bytes, header)
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

fn read_geometry(bytes: &[u8], header: &Header) -> Result<RawMesh, ReadError> {
    let mut source = open(bytes, header);
    let (mut mesh, mut fans) = (RawMesh::default(), Fans::default());
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" => read_vertices(&mut source, element, &mut mesh)?,
            "face" => read_faces(&mut source, element, &mut mesh, &mut fans)?,
            "tristrips" => read_strips(&mut source, element, &mut mesh)?,
            _ => walk(&mut source, &RowRange { element, start: 0, list: None }, |_| (), |_, _| ())?,
        }
    }
    fans.triangulate(&mesh.positions, &mut mesh.faces);
    Ok(mesh)
}

struct RowRange<'a> {
    element: &'a Element,
    start: usize,
    list: Option<usize>,
}

/// Reads an element's rows; passes requested lists to `take_list` and scalars to `take`.
fn walk(
    source: &mut Source,
    rows: &RowRange,
    mut take_list: impl FnMut(&[u32]),
    mut take: impl FnMut(usize, f64),
) -> Result<(), ReadError> {
    let RowRange { element, start, list: wanted } = *rows;
    // An element without properties takes no bytes, whatever its count: a loop over it could take forever.
    let n_rows = if element.properties.is_empty() { 0 } else { element.count };
    let mut list = Vec::new();
    for row in start..n_rows {
        let mut next = |scalar| source.scalar(scalar).ok_or_else(|| source.cut_error(element, row));
        for (i, property) in element.properties.iter().enumerate() {
            let Some(length) = property.length else {
                take(i, next(property.scalar)?);
                continue;
            };
            // A count that is negative or no number means none.
            let n_values = next(length)?.max(0.0) as u64;
            list.clear();
            for _ in 0..n_values {
                let value = next(property.scalar)?;
                if Some(i) == wanted {
                    list.push(index(value));
                }
            }
            if Some(i) == wanted {
                take_list(&list);
            }
        }
        source.end_row();
    }
    Ok(())
}

fn index(value: f64) -> u32 {
    if value >= 0.0 { value as u32 } else { u32::MAX }
}

fn read_vertices(source: &mut Source, element: &Element, mesh: &mut RawMesh) -> Result<(), ReadError> {
    let axes = [element.scalar("x")?, element.scalar("y")?, element.scalar("z")?];
    mesh.double |= axes.iter().any(|&axis| element.properties[axis].scalar.is_wide());
    // Rows of equal length are decoded in parallel, after the check that all of them exist.
    if let (Source::Binary { bytes, at, big }, Some((offsets, stride))) = (&mut *source, element.layout()) {
        // The count is compared with the bytes before memory is reserved.
        let Some(records) = records(&bytes[*at..], element.count, stride) else {
            return Err(source.cut_error(element, source.n_bytes_left() / stride));
        };
        let scalars = axes.map(|axis| (offsets[axis], element.properties[axis].scalar));
        reserve(&mut mesh.positions, element.count)?;
        decode_positions(records, stride, scalars, *big, &mut mesh.positions);
        *at += records.len();
        return Ok(());
    }
    let mut position = [0.0; 3];
    let last = axes.into_iter().max();
    let rows = RowRange { element, start: 0, list: None };
    let take = |property, value| {
        if let Some(axis) = axes.iter().position(|&axis| axis == property) {
            position[axis] = value;
        }
        if last == Some(property) {
            mesh.positions.push(position);
        }
    };
    walk(source, &rows, |_| (), take)
}

fn records(bytes: &[u8], count: usize, stride: usize) -> Option<&[u8]> {
    bytes.get(..count.checked_mul(stride)?)
}

fn decode_positions(
    records: &[u8],
    stride: usize,
    scalars: [(usize, Scalar); 3],
    big: bool,
    positions: &mut Vec<[f64; 3]>,
) {
    let [x, y, z] = scalars;
    let records = records.par_chunks_exact(stride).with_min_len(BLOCK);
    // Three consecutive little-endian floats are the usual layout.
    if !big && [x, y, z] == [(x.0, Scalar::F32), (x.0 + 4, Scalar::F32), (x.0 + 8, Scalar::F32)] {
        positions.par_extend(records.map(|record| {
            let (floats, _) = record[x.0..x.0 + 12].as_chunks::<4>();
            std::array::from_fn(|axis| f64::from(f32::from_le_bytes(floats[axis])))
        }));
    } else {
        let decode =
            |record: &[u8], (offset, scalar): (usize, Scalar)| scalar.decode(&record[offset..], big).unwrap_or(0.0);
        positions.par_extend(records.map(|record| scalars.map(|scalar| decode(record, scalar))));
    }
}

fn read_faces(source: &mut Source, element: &Element, mesh: &mut RawMesh, fans: &mut Fans) -> Result<(), ReadError> {
    let list = element.list(&["vertex_indices", "vertex_index"]);
    // An empty table of faces may lack the list.
    if list.is_none() && element.count > 0 {
        return Err(element.missing_error("list of vertex_indices"));
    }
    // Nearly all files consist of triangles, which are decoded in parallel; other faces go through the loop.
    let start = read_leading_triangles(source, element, &mut mesh.faces)?;
    let RawMesh { faces, dropped_faces, .. } = mesh;
    let take_list = |corners: &[u32]| *dropped_faces += usize::from(!fans.push(corners, faces));
    walk(source, &RowRange { element, start, list }, take_list, |_, _| ())
}

// Faces are read up to the first polygon.
fn read_leading_triangles(
    source: &mut Source,
    element: &Element,
    faces: &mut Vec<[u32; 3]>,
) -> Result<usize, ReadError> {
    let (Source::Binary { bytes, at, big }, [property]) = (source, element.properties.as_slice()) else { return Ok(0) };
    // Other layouts go through the loop over properties.
    // The usual layout has a count of one byte and indices of 32 bits.
    let usual = matches!(property.length, Some(Scalar::U8 | Scalar::I8));
    if !usual || !matches!(property.scalar, Scalar::I32 | Scalar::U32) {
        return Ok(0);
    }
    let records = bytes[*at..].par_chunks_exact(13).with_min_len(BLOCK).take(element.count);
    // A polygon shifts all bytes after it, so the parallel part ends at the first one.
    let n_triangles = records.clone().position_first(|record| record[0] != 3).unwrap_or(records.len());
    let records = records.take(n_triangles);
    reserve(faces, n_triangles)?;
    if *big {
        faces.par_extend(records.map(|record| triangle(record, u32::from_be_bytes)));
    } else {
        faces.par_extend(records.map(|record| triangle(record, u32::from_le_bytes)));
    }
    *at += 13 * n_triangles;
    Ok(n_triangles)
}

fn triangle(record: &[u8], decode: impl Fn([u8; 4]) -> u32) -> [u32; 3] {
    let (corners, _) = record[1..].as_chunks::<4>();
    std::array::from_fn(|corner| decode(corners[corner]))
}

fn read_strips(source: &mut Source, element: &Element, mesh: &mut RawMesh) -> Result<(), ReadError> {
    let list = element.list(&["vertex_indices", "vertex_index"]);
    let list = Some(list.ok_or_else(|| element.missing_error("list of vertex_indices"))?);
    let take = |indices: &[u32]| {
        // -1 starts a new strip; each index after the first two makes a face with those before it.
        for strip in indices.split(|&index| index == u32::MAX) {
            for (i, corners) in strip.windows(3).enumerate() {
                let [a, b, c] = [corners[0], corners[1], corners[2]];
                // Strips repeat a vertex to turn, which makes no face.
                if a != b && b != c && c != a {
                    mesh.faces.push(if i % 2 == 0 { [a, b, c] } else { [b, a, c] });
                }
            }
        }
    };
    walk(source, &RowRange { element, start: 0, list }, take, |_, _| ())
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
