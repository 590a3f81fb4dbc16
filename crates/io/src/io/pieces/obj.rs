//! Reading of OBJ files in runs of whole lines.

use std::io::Read;
use std::path::Path;

use super::{Pieces, PiecesKind, PositionReceiver, REMEDY, open, unreadable};
use crate::io::ReadError;
use crate::io::text::Text;

const RUN: usize = 1 << 20;
const LONGEST_LINE: usize = 64 << 20;

pub fn open_pieces(path: &Path) -> Result<Pieces, ReadError> {
    let (mut n_vertices, mut is_double, mut has_more) = (0u64, false, false);
    each_line(open(path)?, &mut |text, line| {
        match line {
            ObjLine::Vertex => {
                position(text)?;
                n_vertices += 1;
                is_double |= text.double;
            }
            ObjLine::Face => {}
            ObjLine::More => has_more = true,
        }
        Ok(())
    })?;
    let other_content = has_more.then(|| "texture coordinates, normals or materials".into());
    let (kind, n_faces) = (PiecesKind::Obj, n_vertices.saturating_mul(2));
    Ok(Pieces { path: path.into(), kind, n_vertices, n_faces, is_double, other_content })
}

pub fn each_position(file: impl Read, take: &mut PositionReceiver) -> Result<(), ReadError> {
    each_line(file, &mut |text, line| {
        if line == ObjLine::Vertex {
            take(position(text)?);
        }
        Ok(())
    })
}

pub fn each_face(file: impl Read, take: &mut dyn FnMut(&[i64])) -> Result<(), ReadError> {
    let (mut n_before, mut corners) = (0i64, Vec::new());
    each_line(file, &mut |text, line| {
        // Relative indices count back from the vertices read so far.
        if line != ObjLine::Face {
            n_before += i64::from(line == ObjLine::Vertex);
            return Ok(());
        }
        corners.clear();
        while !text.is_line_done() {
            let what = "a corner of a face needs a vertex number";
            let number = text.integer().ok_or_else(|| ReadError::file(what, REMEDY))?;
            corners.push(if number < 0 { n_before.saturating_add(number) } else { number - 1 });
            while !text.is_between_words() {
                text.advance(1);
            }
        }
        take(&corners);
        Ok(())
    })
}

fn position(text: &mut Text) -> Result<[f64; 3], ReadError> {
    text.read_position(Text::skip_blanks).ok_or_else(|| ReadError::file("a vertex needs three numbers", REMEDY))
}

#[derive(Clone, Copy, PartialEq)]
enum ObjLine {
    Vertex,
    Face,
    More,
}

fn each_line(
    mut file: impl Read,
    show: &mut dyn FnMut(&mut Text, ObjLine) -> Result<(), ReadError>,
) -> Result<(), ReadError> {
    let mut bytes: Vec<u8> = Vec::new();
    loop {
        // Bytes after the last complete line are kept for the next run.
        let n_before = bytes.len();
        let n_read = file.by_ref().take(RUN as u64).read_to_end(&mut bytes).map_err(|error| unreadable(&error))?;
        let is_last = n_read == 0;
        // The last line may lack its end.
        let end = if is_last { Some(bytes.len()) } else { end_of_lines(&bytes, n_before) };
        // Without a line end, reading goes on until the line is too long.
        let Some(end) = end else {
            if bytes.len() > LONGEST_LINE {
                return Err(ReadError::file("a line is too long", REMEDY));
            }
            continue;
        };
        let mut text = Text::new(&bytes[..end]).with_continuation();
        while !text.is_at_end() {
            text.skip_blanks();
            let line = match text.rest() {
                [b'v', b' ' | b'\t' | b'\\', ..] => Some(ObjLine::Vertex),
                // Geometry is recognised as in the reader of whole files.
                [b'f', b' ' | b'\t' | b'\\', ..] => Some(ObjLine::Face),
                [b'v', b't' | b'n', b' ' | b'\t', ..] | [b'u', b's', b'e', b'm', b't', b'l', ..] => Some(ObjLine::More),
                _ => None,
            };
            if let Some(line) = line {
                text.advance(1);
                show(&mut text, line)?;
            }
            text.skip_line();
        }
        if is_last {
            return Ok(());
        }
        bytes.drain(..end);
    }
}

// Lines before `from` are known to be incomplete.
fn end_of_lines(bytes: &[u8], from: usize) -> Option<usize> {
    let ends = memchr::memrchr_iter(b'\n', &bytes[from..]).map(|at| from + at);
    // A line that ends in a backslash goes on in the next one.
    let is_continued = |at: usize| bytes[..at].strip_suffix(b"\r").unwrap_or(&bytes[..at]).ends_with(b"\\");
    ends.into_iter().find(|&at| !is_continued(at)).map(|at| at + 1)
}
