//! Files read in runs of whole lines or rows, for those larger than memory.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use super::ReadError;
use crate::mesh::RawMesh;
use crate::mesh::fallible_allocation::with_fallible_allocation;

const REMEDY: &str = "the file is cut or damaged, export the mesh again";
/// Bytes read at once.
const RUN: usize = 1 << 20;

/// Part of the geometry that a reader looks at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum PieceContent {
    #[default]
    All,
    Positions,
    Faces,
}

/// Sizes of a file that is read in pieces.
#[derive(Debug, Default)]
pub(super) struct FileOutline {
    // Zero for STL, which has no vertices to keep in memory.
    pub n_vertices: u64,
    pub n_faces: u64,
    pub is_double: bool,
    pub other_content: Option<String>,
}

/// Receiver of pieces; their faces refer to the vertices of the whole file.
pub(super) type PieceReceiver<'a> = dyn FnMut(&RawMesh) + 'a;

/// Opens the file at `path` at a byte.
pub(super) fn open_at(path: &Path, byte: u64) -> Result<File, ReadError> {
    let mut file = with_fallible_allocation(|| File::open(path)).map_err(unreadable)?;
    file.seek(SeekFrom::Start(byte)).map_err(unreadable)?;
    Ok(file)
}

pub(super) fn read_beginning(path: &Path, most: u64) -> Result<Vec<u8>, ReadError> {
    let mut bytes = Vec::new();
    open_at(path, 0)?.take(most).read_to_end(&mut bytes).map_err(unreadable)?;
    Ok(bytes)
}

/// Passes a file to `take` in runs; each begins with the bytes that the last call left.
///
/// `take` receives whether the run is the last. It returns the number of bytes it used, or `None` if it needs no more.
pub(super) fn each_run(
    mut file: File,
    most_unused: usize,
    mut take: impl FnMut(&[u8], bool) -> Result<Option<usize>, ReadError>,
) -> Result<(), ReadError> {
    let mut bytes = Vec::new();
    loop {
        // A run doubles while nothing of it is used, so that its beginning is not read too often.
        let n_more = RUN.max(bytes.len()) as u64;
        let n_read = file.by_ref().take(n_more).read_to_end(&mut bytes).map_err(unreadable)?;
        let Some(n_used) = take(&bytes, n_read == 0)? else { return Ok(()) };
        bytes.drain(..n_used);
        if n_read == 0 {
            return Ok(());
        }
        if bytes.len() > most_unused {
            return Err(ReadError::file("a line or row is too long", REMEDY));
        }
    }
}

/// Passes rows of `stride` bytes to `take`, many at once.
pub(super) fn each_run_of_rows(
    file: File,
    stride: usize,
    n_rows: u64,
    mut take: impl FnMut(&[u8]),
) -> Result<(), ReadError> {
    let mut n_left = n_rows;
    each_run(file, stride, |bytes, is_last| {
        let n = ((bytes.len() / stride) as u64).min(n_left);
        let n_used = stride * n as usize;
        take(&bytes[..n_used]);
        n_left -= n;
        rest_of_run(n_used, n_left, is_last)
    })
}

/// Returns the answer to a run of a receiver that needs this many more rows.
pub(super) fn rest_of_run(n_used: usize, n_rows_left: u64, is_last: bool) -> Result<Option<usize>, ReadError> {
    match (n_rows_left, is_last) {
        (0, _) => Ok(None),
        (_, true) => Err(cut_error()),
        _ => Ok(Some(n_used)),
    }
}

pub(super) fn cut_error() -> ReadError {
    ReadError::file("the file ends too soon", REMEDY)
}

pub(super) fn unreadable(error: std::io::Error) -> ReadError {
    ReadError::file(format!("the file cannot be read: {error}"), "check the file")
}
