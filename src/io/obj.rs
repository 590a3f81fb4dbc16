//! Wavefront OBJ: positions and faces; materials, texture coordinates, normals, curves and lines are passed over.

use super::ReadError;
use super::text::Text;
use super::write::push_position;
use crate::mesh::{Fans, Frame, RawMesh, TriMesh};

/// An index that no vertex has: faces with it are for cleanup to drop.
const NOWHERE: u32 = u32::MAX;

/// Reads an OBJ text: BOM, CRLF, continued lines, relative indices and comments in any encoding are fine.
pub(super) fn read(bytes: &[u8]) -> Result<RawMesh, ReadError> {
    let mut text = Text::new(bytes).with_continuation();
    let (mut mesh, mut fans, mut corners) = (RawMesh::default(), Fans::default(), Vec::new());
    while !text.is_at_end() {
        text.skip_blanks();
        match text.rest() {
            [b'v', b' ' | b'\t' | b'\\', ..] => {
                text.advance(1);
                mesh.positions.push(read_position(&mut text)?);
            }
            [b'f', b' ' | b'\t' | b'\\' | b'\r' | b'\n', ..] | [b'f'] => {
                text.advance(1);
                read_corners(&mut text, mesh.positions.len(), &mut corners)?;
                mesh.dropped_faces += usize::from(!fans.push(&corners, &mut mesh.faces));
            }
            _ => {}
        }
        text.skip_line();
    }
    fans.settle(&mesh.positions, &mut mesh.faces);
    mesh.double = text.double;
    Ok(mesh)
}

/// Three numbers; a weight or a colour may follow.
fn read_position(text: &mut Text) -> Result<[f64; 3], ReadError> {
    let mut position = [0.0; 3];
    for x in &mut position {
        text.skip_blanks();
        let problem = "a vertex needs three numbers";
        *x = text.number().ok_or_else(|| text.error(problem, "mend the line or export the mesh again"))?;
    }
    Ok(position)
}

/// The vertex of each `v`, `v/vt`, `v//vn` or `v/vt/vn` up to the end of the line.
fn read_corners(text: &mut Text, n_vertices: usize, corners: &mut Vec<u32>) -> Result<(), ReadError> {
    corners.clear();
    while !text.is_line_done() {
        let problem = "a corner of a face needs a vertex number";
        let index = text.integer().ok_or_else(|| text.error(problem, "mend the line or export the mesh again"))?;
        let from_zero = if index < 0 { n_vertices as i64 + index } else { index - 1 };
        corners.push(u32::try_from(from_zero).unwrap_or(NOWHERE));
        while !text.is_between_words() {
            text.advance(1);
        }
    }
    Ok(())
}

/// Writes an OBJ text with the shortest digits that read back as the same numbers.
pub(super) fn write(mesh: &TriMesh, frame: &Frame) -> Vec<u8> {
    let mut out = Vec::with_capacity(40 * mesh.positions().len() + 24 * mesh.faces().len());
    for &position in mesh.positions() {
        out.extend(b"v ");
        push_position(&mut out, frame, position);
        out.push(b'\n');
    }
    let mut digits = itoa::Buffer::new();
    for face in mesh.faces() {
        out.push(b'f');
        for &vertex in face {
            out.push(b' ');
            out.extend(digits.format(vertex + 1).as_bytes());
        }
        out.push(b'\n');
    }
    out
}
