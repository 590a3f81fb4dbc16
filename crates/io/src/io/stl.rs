//! STL, binary and text.

use std::path::Path;

use super::format::{announced_stl_faces, is_binary_stl};
use super::memory::add_zeros;
use super::runs::{FileOutline, PieceReceiver, cut_error, each_run_of_rows, open_at, read_beginning, unreadable};
use super::text::Text;
use super::write::{Content, push_singles};
use super::{ReadError, WriteError};
use crate::mesh::{Fans, RawMesh};
use crate::parallel;

const REMEDY: &str = "export the mesh again";
const BLOCK: usize = 1 << 14;
/// Bytes of the header of a binary file, with the number of faces, and of a face.
const HEAD: usize = 84;
const RECORD: usize = 50;

/// Reads an STL; a binary one may begin with `solid`.
pub(super) fn read(bytes: &[u8]) -> Result<RawMesh, ReadError> {
    if begins_as_text(bytes) && !is_binary_stl(bytes) { read_text(Text::new(bytes)) } else { read_binary(bytes) }
}

fn begins_as_text(bytes: &[u8]) -> bool {
    let opening = Text::new(bytes).rest().trim_ascii_start().get(..5).unwrap_or_default();
    // Text has no zero byte; the header and count of a binary file almost always have one.
    opening.eq_ignore_ascii_case(b"solid") && !bytes.iter().take(HEAD).any(|&byte| byte == 0)
}

/// Describes a binary STL that is read in pieces; returns `None` for one in text form.
pub(super) fn outline(path: &Path) -> Result<Option<FileOutline>, ReadError> {
    let start = read_beginning(path, HEAD as u64)?;
    let n_bytes = std::fs::metadata(path).map_err(unreadable)?.len();
    let Some(count) = announced_stl_faces(&start) else { return Ok(None) };
    let n_faces = u64::from(count);
    match HEAD as u64 + RECORD as u64 * n_faces <= n_bytes {
        // The size decides first: binary headers may begin with `solid` as well.
        true => Ok(Some(FileOutline { n_faces, ..FileOutline::default() })),
        false if begins_as_text(&start) => Ok(None),
        false => Err(cut_error()),
    }
}

/// Passes the corners of a binary STL's faces to `take`.
pub(super) fn each_piece(path: &Path, n_faces: u64, take: &mut PieceReceiver) -> Result<(), ReadError> {
    let mut piece = RawMesh::default();
    each_run_of_rows(open_at(path, HEAD as u64)?, RECORD, n_faces, |records| {
        piece.positions.resize(3 * (records.len() / RECORD), [0.0; 3]);
        decode_corners(records, &mut piece.positions);
        take(&piece);
    })
}

pub(super) fn notes(bytes: &[u8]) -> Vec<String> {
    let records = bytes.get(HEAD..).unwrap_or_default().chunks_exact(RECORD);
    // Two bytes per facet hold colours in several dialects.
    let n_marked = records.filter(|record| record[48..] != [0, 0]).count();
    if is_binary_stl(bytes) && n_marked > 0 {
        return vec![format!("colours or other marks of {n_marked} stl facets are dropped")];
    }
    let is_end =
        |line: &[u8]| line.trim_ascii_start().get(..8).is_some_and(|word| word.eq_ignore_ascii_case(b"endsolid"));
    let n_solids = bytes.split(|&byte| byte == b'\n').filter(|line| is_end(line)).count();
    if n_solids > 1 {
        vec![format!("{n_solids} stl solids become one mesh, their names are dropped")]
    } else {
        Vec::new()
    }
}

fn read_binary(bytes: &[u8]) -> Result<RawMesh, ReadError> {
    let Some(count) = announced_stl_faces(bytes) else {
        return Err(ReadError::file(format!("{} bytes are too few for a binary file", bytes.len()), REMEDY));
    };
    let records = bytes[HEAD..].chunks_exact(RECORD).take(count as usize);
    if records.len() < count as usize {
        // The check precedes any allocation: the count may be damaged.
        let room = records.len();
        let what = format!("the header announces {count} faces, the file has room for {room}");
        return Err(ReadError::byte(80, what, "the file is cut or damaged, export the mesh again"));
    }
    let mut positions = Vec::new();
    add_zeros(&mut positions, 3 * records.len())?;
    decode_corners(&bytes[HEAD..HEAD + RECORD * records.len()], &mut positions);
    // No two faces share vertices; cleanup welds them.
    let faces = (0..count).map(|face| [0, 1, 2].map(|corner| face.saturating_mul(3).saturating_add(corner))).collect();
    Ok(RawMesh { positions, faces, ..RawMesh::default() })
}

fn decode_corners(records: &[u8], positions: &mut [[f64; 3]]) {
    let corner = |record: &[u8], corner: usize| {
        let (floats, _) = record[12 + 12 * corner..24 + 12 * corner].as_chunks::<4>();
        std::array::from_fn(|axis| f64::from(f32::from_le_bytes(floats[axis])))
    };
    parallel::fill(positions, BLOCK, |i| corner(&records[RECORD * (i / 3)..][..RECORD], i % 3));
}

fn read_text(mut text: Text) -> Result<RawMesh, ReadError> {
    let (mut mesh, mut fans, mut corners) = (RawMesh::default(), Fans::default(), Vec::new());
    let mut open = false;
    loop {
        text.skip_space();
        let word = text.word();
        match word.len() {
            // A cut text would lose its last facet unnoticed.
            0 if open => return Err(text.error("the text ends inside a facet", REMEDY)),
            0 => break,
            _ if word.eq_ignore_ascii_case(b"vertex") => {
                corners.push(mesh.positions.len() as u32);
                let position = text.read_position(Text::skip_space);
                mesh.positions.push(position.ok_or_else(|| text.error("a vertex needs three numbers", REMEDY))?);
            }
            _ if word.eq_ignore_ascii_case(b"facet") => open = true,
            // Facets may have more than three corners, which the format forbids and programs write.
            _ if word.eq_ignore_ascii_case(b"endfacet") => {
                mesh.dropped_faces += usize::from(!fans.push(&corners, &mut mesh.faces));
                corners.clear();
                open = false;
            }
            _ if word.eq_ignore_ascii_case(b"solid") || word.eq_ignore_ascii_case(b"endsolid") => text.skip_line(),
            _ => {}
        }
    }
    fans.triangulate(&mesh.positions, &mut mesh.faces);
    mesh.double = text.double;
    Ok(mesh)
}

/// Writes a binary STL.
pub(super) fn write_binary(content: &Content) -> Result<Vec<u8>, WriteError> {
    // Numbers beyond single precision would become infinite.
    let positions = single_positions(content)?;
    let mut out = vec![0; 84 + 50 * content.faces.len()];
    out[..80].fill(b' ');
    out[80..84].copy_from_slice(&(content.faces.len() as u32).to_le_bytes());
    parallel::rows_mut(&mut out[84..], RECORD, BLOCK, |face, record| {
        let corners = content.faces[face].map(|vertex| positions[vertex as usize]);
        let floats = normal(corners).into_iter().chain(corners.into_iter().flatten());
        for (bytes, float) in record.chunks_exact_mut(4).zip(floats) {
            bytes.copy_from_slice(&float.to_le_bytes());
        }
    });
    Ok(out)
}

/// Writes a text STL.
pub(super) fn write_text(content: &Content) -> Result<Vec<u8>, WriteError> {
    let positions = single_positions(content)?;
    let mut out = Vec::with_capacity(260 * content.faces.len() + 64);
    out.extend(b"solid mesh\n");
    for face in content.faces {
        let corners = face.map(|vertex| positions[vertex as usize]);
        out.extend(b"facet normal ");
        push_singles(&mut out, &normal(corners));
        out.extend(b"\nouter loop\n");
        for corner in corners {
            out.extend(b"vertex ");
            push_singles(&mut out, &corner);
            out.push(b'\n');
        }
        out.extend(b"endloop\nendfacet\n");
    }
    out.extend(b"endsolid mesh\n");
    Ok(out)
}

fn single_positions(content: &Content) -> Result<Vec<[f32; 3]>, WriteError> {
    let positions: Vec<_> = (0..content.n_vertices()).map(|v| content.position(v).map(|x| x as f32)).collect();
    if positions.iter().flatten().all(|x| x.is_finite()) {
        return Ok(positions);
    }
    Err(WriteError::new("coordinates beyond the range of single precision, the only precision of STL: write PLY"))
}

fn normal(corners: [[f32; 3]; 3]) -> [f32; 3] {
    let [a, b, c] = corners.map(glam::Vec3::from);
    let [p, q] = [b - a, c - a].map(|side| side.to_array());
    // Products are rounded as in admesh, which reports differing normals; this matters for needles.
    let product = |i: usize, j: usize| f64::from(p[i]) * f64::from(q[j]);
    let rounded = |i: usize, j: usize| (f64::from(product(i, j) as f32) - product(j, i)) as f32;
    let normal = glam::Vec3::new(rounded(1, 2), rounded(2, 0), rounded(0, 1)).as_dvec3();
    let length = normal.length();
    if length >= f64::from(f32::MIN_POSITIVE) && length.is_finite() {
        return (normal / length).as_vec3().to_array();
    }
    // The product is too small or too large for single precision.
    let [a, b, c] = corners.map(|p| glam::Vec3::from(p).as_dvec3());
    (b - a).cross(c - a).normalize_or_zero().as_vec3().to_array()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Frame, TriMesh};

    fn triangle() -> TriMesh {
        TriMesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.5]], vec![[0, 1, 2]]).unwrap()
    }

    #[test]
    fn solids_in_any_case_are_one_mesh() {
        let facet =
            "FACET Normal 0 0 1\n outer LOOP\n Vertex 0 0 0\n VERTEX 1e0 0 0\n vertex 0 1. 0\n endloop\nEndFacet\n";
        let text = format!("\u{feff} SOLID vertex facet\n{facet}endsolid vertex\r\nsolid\n{facet}{facet}endsolid");
        let mesh = read(text.as_bytes()).unwrap();
        assert_eq!((mesh.positions.len(), mesh.faces.len()), (9, 3));
        assert_eq!(mesh.positions[1], [1.0, 0.0, 0.0]);
    }

    #[test]
    fn facets_of_more_and_fewer_corners() {
        let text = "solid\nfacet\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\nendfacet\nfacet\nvertex 0 0 0\nendfacet\n";
        let mesh = read(text.as_bytes()).unwrap();
        assert_eq!((mesh.faces.len(), mesh.dropped_faces), (2, 1));
    }

    #[test]
    fn binary_files_may_say_solid_and_have_bytes_behind() {
        let mut bytes = write_binary(&Content::from_mesh(&triangle(), &Frame::default())).unwrap();
        bytes[..5].copy_from_slice(b"solid");
        let mesh = read(&bytes).unwrap();
        bytes.extend(b"\0\0words");
        assert_eq!(read(&bytes).unwrap(), mesh);
        assert_eq!(mesh.positions[2], [0.0, 1.0, 0.5]);
    }

    #[test]
    fn cut_files_are_refused() {
        let mut bytes = write_binary(&Content::from_mesh(&triangle(), &Frame::default())).unwrap();
        bytes[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
        let error = read(&bytes).unwrap_err().to_string();
        assert!(error.contains("announces 4294967295 faces, the file has room for 1"), "{error}");
        let text = write_text(&Content::from_mesh(&triangle(), &Frame::default())).unwrap();
        assert!(read(&text[..text.len() - 30]).unwrap_err().to_string().contains("ends inside a facet"));
        for length in [0, 3, 83] {
            assert!(read(&vec![0; length]).is_err());
        }
    }

    #[test]
    fn normals_are_those_of_the_faces() {
        let text = String::from_utf8(write_text(&Content::from_mesh(&triangle(), &Frame::default())).unwrap()).unwrap();
        assert!(text.contains("facet normal 0 -0.4472136 0.8944272"), "{text}");
    }

    #[test]
    fn coordinates_beyond_single_precision_are_refused() {
        let frame = Frame { origin: [1e300, 0.0, 0.0], double: true };
        assert!(write_binary(&Content::from_mesh(&triangle(), &frame)).is_err());
        assert!(write_text(&Content::from_mesh(&triangle(), &frame)).is_err());
    }
}
