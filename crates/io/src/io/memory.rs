//! Bounded reading, and memory for large arrays without aborts.

use std::io::{self, Read};
use std::path::Path;

use super::ReadError;
use crate::mesh::fallible_allocation::{make_room, with_fallible_allocation};

/// Longest stream in bytes.
const LONGEST_STREAM: u64 = 1 << 32;

/// Largest number of vertices and faces in all instances: the first times the stored ones, plus the second.
#[cfg(any(feature = "gltf", feature = "3mf", feature = "fbx"))]
const REPEATS: (usize, usize) = (16, 1 << 22);

#[cfg(any(feature = "gltf", feature = "3mf", feature = "fbx"))]
pub(super) fn instance_limit(n_held: usize) -> usize {
    REPEATS.0 * n_held + REPEATS.1
}

#[inline]
pub(super) fn reserve<T>(list: &mut Vec<T>, n: usize) -> Result<(), ReadError> {
    make_room(list, n).map_err(|_| {
        let n_bytes = n.saturating_mul(size_of::<T>());
        let what = format!("the file needs more memory than is available ({n_bytes} bytes more)");
        ReadError::file(what, "give a smaller file or more memory")
    })
}

#[cfg(any(test, feature = "gltf"))]
pub(super) fn allocate_zeros<T: Clone + Default>(n: usize) -> Result<Vec<T>, ReadError> {
    let mut list = Vec::new();
    add_zeros(&mut list, n)?;
    Ok(list)
}

/// Adds `n` zeros to a list. One without memory gets it from the system, which clears it where it is first written.
pub(super) fn add_zeros<T: Clone + Default>(list: &mut Vec<T>, n: usize) -> Result<(), ReadError> {
    if list.capacity() > 0 {
        reserve(list, n)?;
        list.resize(list.len() + n, T::default());
    } else {
        // Fails where memory is too small, at which `vec!` would end the program.
        reserve(&mut Vec::<T>::new(), n)?;
        *list = vec![T::default(); n];
    }
    Ok(())
}

pub(super) fn io_error(error: io::Error) -> ReadError {
    match error.kind() {
        io::ErrorKind::OutOfMemory => {
            ReadError::file("the file needs more memory than is available", "give a smaller file or more memory")
        }
        io::ErrorKind::IsADirectory => ReadError::file("is a folder", "give the mesh files in it, as FOLDER/*.ply"),
        _ => ReadError::file(format!("cannot be read: {error}"), "check the path"),
    }
}

/// Reads the file at `path`; rejects devices and long pipes.
///
/// # Errors
/// [`ReadError`], without the path.
///
/// ```
/// # use neural_mesh_io as neural_mesh;
/// let error = neural_mesh::io::read_file("no/such/file".as_ref()).unwrap_err();
/// assert!(error.to_string().starts_with("cannot be read"));
/// ```
pub fn read_file(path: &Path) -> Result<Vec<u8>, ReadError> {
    // The kind is checked before opening, as opening a device may block or have effects.
    let kind = std::fs::metadata(path).map_err(io_error)?.file_type();
    // Reading a folder fails with an error of its own, which `io_error` explains.
    if kind.is_file() || kind.is_dir() {
        return with_fallible_allocation(|| std::fs::read(path)).map_err(io_error);
    }
    if is_device(kind) {
        return Err(ReadError::file("is a device and has no end", "give a file, or - for standard input"));
    }
    read_stream(std::fs::File::open(path).map_err(io_error)?)
}

/// Reads a stream of up to 4 GiB.
///
/// # Errors
/// [`ReadError`] if the stream fails, is longer, or does not fit into memory.
///
/// ```
/// # use neural_mesh_io as neural_mesh;
/// assert_eq!(neural_mesh::io::read_stream(&b"v 0 0 0"[..]).unwrap(), b"v 0 0 0");
/// ```
pub fn read_stream(stream: impl Read) -> Result<Vec<u8>, ReadError> {
    read_at_most(stream, LONGEST_STREAM)
}

fn read_at_most(stream: impl Read, most: u64) -> Result<Vec<u8>, ReadError> {
    let mut bytes = Vec::new();
    with_fallible_allocation(|| stream.take(most + 1).read_to_end(&mut bytes)).map_err(io_error)?;
    match bytes.len() as u64 > most {
        true => Err(ReadError::file(format!("is longer than {most} bytes"), "give the mesh as a file, by its path")),
        false => Ok(bytes),
    }
}

#[cfg(unix)]
fn is_device(kind: std::fs::FileType) -> bool {
    use std::os::unix::fs::FileTypeExt;
    kind.is_char_device() || kind.is_block_device()
}

#[cfg(not(unix))]
fn is_device(_: std::fs::FileType) -> bool {
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stream_without_end_is_refused() {
        let error = read_at_most(io::repeat(0), 1 << 20).unwrap_err();
        assert_eq!(error.to_string(), "is longer than 1048576 bytes: give the mesh as a file, by its path");
        assert_eq!(read_at_most(io::repeat(7).take(1 << 20), 1 << 20).unwrap().len(), 1 << 20);
    }

    #[cfg(unix)]
    #[test]
    fn a_device_is_refused_before_it_is_read() {
        let error = read_file(Path::new("/dev/zero")).unwrap_err();
        assert!(error.to_string().starts_with("is a device and has no end: "), "{error}");
    }

    #[test]
    fn what_no_memory_holds_is_an_error() {
        for error in
            [reserve(&mut vec![0u64], usize::MAX).unwrap_err(), allocate_zeros::<f32>(usize::MAX / 4).unwrap_err()]
        {
            assert!(error.what.starts_with("the file needs more memory than is available"), "{error}");
        }
    }
}
