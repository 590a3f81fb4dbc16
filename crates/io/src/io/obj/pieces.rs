//! Reading of an OBJ in pieces.

use std::path::Path;

use super::ObjReader;
use crate::io::ReadError;
use crate::io::runs::{FileOutline, PieceContent, PieceReceiver, each_run, open_at};

const LONGEST_LINE: usize = 64 << 20;

/// Counts the vertices of an OBJ; assumes two faces per vertex.
pub(in crate::io) fn outline(path: &Path) -> Result<FileOutline, ReadError> {
    let (mut outline, mut has_more) = (FileOutline::default(), false);
    each_run_of_lines(path, PieceContent::Positions, &mut |lines, reader| {
        outline.n_vertices += reader.mesh.positions.len() as u64;
        outline.is_double |= reader.mesh.double;
        has_more = has_more || lines.split(|&byte| byte == b'\n').any(has_other_content);
    })?;
    outline.n_faces = outline.n_vertices.saturating_mul(2);
    outline.other_content = has_more.then(|| "texture coordinates, normals or materials".into());
    Ok(outline)
}

fn has_other_content(line: &[u8]) -> bool {
    matches!(line.trim_ascii_start(), [b'v', b't' | b'n', ..] | [b'u', b's', b'e', b'm', b't', b'l', ..])
}

pub(in crate::io) fn each_piece(path: &Path, content: PieceContent, take: &mut PieceReceiver) -> Result<(), ReadError> {
    each_run_of_lines(path, content, &mut |_, reader| take(&reader.mesh))
}

fn each_run_of_lines(
    path: &Path,
    content: PieceContent,
    take: &mut dyn FnMut(&[u8], &ObjReader),
) -> Result<(), ReadError> {
    let (mut n_before, mut n_lines, mut n_searched) = (0, 0, 0);
    each_run(open_at(path, 0)?, LONGEST_LINE, |bytes, is_last| {
        // The last line may lack its end; without any end, reading goes on.
        let end = if is_last { bytes.len() } else { end_of_lines(bytes, n_searched) };
        let lines = &bytes[..end];
        let mut reader = ObjReader { content, n_before, ..ObjReader::default() };
        reader.read(lines).map_err(|error| error.after_lines(n_lines))?;
        take(lines, &reader);
        n_before = reader.n_before + reader.mesh.positions.len();
        n_lines += memchr::memchr_iter(b'\n', lines).count();
        n_searched = if end == 0 { bytes.len() } else { 0 };
        Ok(Some(end))
    })
}

/// Returns the end of the last complete line, or zero; no line ends before `from`.
fn end_of_lines(bytes: &[u8], from: usize) -> usize {
    let mut ends = memchr::memrchr_iter(b'\n', &bytes[from..]).map(|at| from + at);
    // A line that ends in a backslash goes on in the next one.
    let is_continued = |at: usize| bytes[..at].strip_suffix(b"\r").unwrap_or(&bytes[..at]).ends_with(b"\\");
    ends.find(|&at| !is_continued(at)).map_or(0, |at| at + 1)
}
