//! Reading of a binary PLY in pieces: positions alone, or faces alone.

use std::path::Path;

use super::header::{Element, Encoding, Header};
use super::reader::{LIST_NAMES, read_polygon, read_rows};
use super::source::Source;
use super::{decode_positions, read_leading_triangles};
use crate::io::runs::{
    FileOutline, PieceContent, PieceReceiver, each_run, each_run_of_rows, open_at, read_beginning, rest_of_run,
};
use crate::io::{ReadError, Scalar};
use crate::mesh::{Fans, RawMesh};

const LONGEST_HEADER: u64 = 1 << 20;
/// Longest row of a face in bytes: a million corners.
const LONGEST_ROW: usize = 4 << 20;

/// Places of the geometry in a binary PLY.
#[derive(Debug)]
pub(in crate::io) struct PlyLayout {
    big: bool,
    body: u64,
    n_vertices: u64,
    stride: usize,
    axes: [(usize, Scalar); 3],
    faces: Element,
    list: usize,
}

impl PlyLayout {
    /// Reads the header of a file; returns `None` unless it is binary, with a table of vertices and then one of faces.
    pub fn open(path: &Path) -> Result<Option<(Self, FileOutline)>, ReadError> {
        // The header of a mesh is not longer than this.
        let header = Header::parse(&read_beginning(path, LONGEST_HEADER)?)?;
        // Text, other tables and another order are left to the reader of whole files.
        let [vertices, faces] = &header.elements[..] else { return Ok(None) };
        // Vertices of fixed length can be skipped without reading them.
        let (Some((offsets, stride)), Some(list)) = (vertices.layout(), faces.list(&LIST_NAMES)) else {
            return Ok(None);
        };
        if header.encoding == Encoding::Text || [&*vertices.name, &*faces.name] != ["vertex", "face"] {
            return Ok(None);
        }
        let columns = [vertices.scalar("x")?, vertices.scalar("y")?, vertices.scalar("z")?];
        let axes = columns.map(|at| (offsets[at], vertices.properties[at].scalar));
        let others = |element: &Element, known: &[usize]| -> Vec<String> {
            let properties = element.properties.iter().enumerate().filter(|(at, _)| !known.contains(at));
            properties.map(|(_, property)| property.name.clone()).collect()
        };
        let others = [others(vertices, &columns), others(faces, &[list])].concat();
        let outline = FileOutline {
            n_vertices: vertices.count as u64,
            n_faces: faces.count as u64,
            is_double: axes.iter().any(|(_, scalar)| scalar.is_wide()),
            other_content: (!others.is_empty()).then(|| others.join(", ")),
        };
        let (big, body) = (header.encoding == Encoding::BigEndian, header.body as u64);
        let (n_vertices, faces) = (outline.n_vertices, faces.clone());
        Ok(Some((Self { big, body, n_vertices, stride, axes, faces, list }, outline)))
    }

    pub fn each_piece(&self, path: &Path, content: PieceContent, take: &mut PieceReceiver) -> Result<(), ReadError> {
        let mut piece = RawMesh::default();
        if content == PieceContent::Positions {
            return each_run_of_rows(open_at(path, self.body)?, self.stride, self.n_vertices, |rows| {
                piece.positions.resize(rows.len() / self.stride, [0.0; 3]);
                decode_positions(rows, self.stride, self.axes, self.big, &mut piece.positions);
                take(&piece);
            });
        }
        // Faces begin right after the vertices, so these are not read again.
        let start = self.n_vertices.saturating_mul(self.stride as u64).saturating_add(self.body);
        let (mut n_done, mut polygon) = (0, Vec::new());
        each_run(open_at(path, start)?, LONGEST_ROW, |bytes, is_last| {
            let mut source = Source::Binary { bytes, at: 0, big: self.big };
            piece.faces.clear();
            piece.dropped_faces = 0;
            let mut fans = Fans::default();
            n_done += read_leading_triangles(&mut source, &self.faces, n_done, &mut piece.faces)?;
            n_done = read_rows(&mut source, &self.faces, n_done, |row| {
                read_polygon(&row[self.list], &mut polygon);
                piece.dropped_faces += usize::from(!fans.push(&polygon, &mut piece.faces));
            });
            take(&piece);
            rest_of_run(bytes.len() - source.n_bytes_left(), (self.faces.count - n_done) as u64, is_last)
        })
    }
}
