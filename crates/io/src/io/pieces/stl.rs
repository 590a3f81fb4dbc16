//! Reading of binary STL files as streams.

use std::io::Read;
use std::path::Path;

use super::{Pieces, PiecesKind, Triangle, read_beginning, unreadable};
use crate::io::ReadError;

/// Opens an STL; returns `None` for one in text form.
pub fn open_pieces(path: &Path) -> Result<Option<Pieces>, ReadError> {
    // The header is 80 bytes, the count four.
    let start = read_beginning(path, 84)?;
    let n_bytes = std::fs::metadata(path).map_err(|error| unreadable(&error))?.len();
    let Some(count) = start.get(80..84).and_then(|count| count.first_chunk()).map(|count| u32::from_le_bytes(*count))
    else {
        return Ok(None);
    };
    // The size decides first: binary headers may begin with `solid` as well.
    let fits = 84 + 50 * u64::from(count) <= n_bytes;
    let is_text = start.trim_ascii_start().starts_with(b"solid") && !start.contains(&0);
    let (kind, n_faces) = (PiecesKind::Stl, u64::from(count));
    match (is_text, fits) {
        (_, true) => {
            Ok(Some(Pieces { path: path.into(), kind, n_vertices: 0, n_faces, is_double: false, other_content: None }))
        }
        (true, false) => Ok(None),
        (false, false) => Err(unreadable(&std::io::ErrorKind::UnexpectedEof.into())),
    }
}

pub fn each_triangle(mut file: impl Read, n_faces: u64, mut take: impl FnMut(Triangle)) -> Result<(), ReadError> {
    let mut record = [0; 84];
    file.read_exact(&mut record).map_err(|error| unreadable(&error))?;
    let record = &mut record[..50];
    for _ in 0..n_faces {
        file.read_exact(record).map_err(|error| unreadable(&error))?;
        let floats = record[12..48].as_chunks::<4>().0;
        take([0, 3, 6].map(|at| [0, 1, 2].map(|axis| f32::from_le_bytes(floats[at + axis]))));
    }
    Ok(())
}
