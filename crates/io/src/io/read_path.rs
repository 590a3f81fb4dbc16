//! Reading of mesh files by path.

use std::borrow::Cow;
use std::io::Read;
use std::path::Path;

use super::memory::read_file;
use super::uri::fetch;
use super::{Folder, Format, ReadError, ReadMesh, gzip, read_attributed_with, read_with};
use crate::mesh::RawMesh;

const FIRST: u64 = 4096;

/// Reads the mesh file at `path`; without a `format`, its name or content decides.
///
/// # Errors
/// [`ReadError`], without the path.
///
/// ```
/// # use neural_mesh_io as neural_mesh;
/// let error = neural_mesh::io::read_path("no/such/mesh.obj".as_ref(), None).unwrap_err();
/// assert!(error.to_string().starts_with("cannot be read"));
/// ```
pub fn read_path(path: &Path, format: Option<Format>) -> Result<RawMesh, ReadError> {
    let bytes = read_decompressed(path)?;
    let folder = Folder::from_file(path);
    let fetch = |uri: &str| fetch(&folder, uri);
    let read = |format| read_with(&bytes, format, &fetch);
    read_as_named_or_shown(&bytes, path, format, read, |mesh| !mesh.faces.is_empty())
}

/// Reads the file at `path` with all attributes; without a `format`, its name or content decides.
///
/// # Errors
/// [`ReadError`], without the path.
///
/// ```
/// # use neural_mesh_io as neural_mesh;
/// let folder = tempfile::tempdir().unwrap();
/// let path = folder.path().join("mesh.obj");
/// std::fs::write(&path, "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
/// let read = neural_mesh::io::read_attributed_path(&path, None).unwrap();
/// assert_eq!((read.extra.folder, read.extra.material_libraries.len()), (Some(neural_mesh::io::Folder::from_file(&path)), 1));
/// ```
pub fn read_attributed_path(path: &Path, format: Option<Format>) -> Result<ReadMesh, ReadError> {
    read_attributed_bytes(&read_decompressed(path)?, path, format, Folder::from_file(path))
}

/// Reads a mesh and its attributes from the bytes of a file `name`, with companion files in `folder`.
///
/// # Errors
/// As [`read_attributed_path`].
pub fn read_attributed_in(bytes: &[u8], name: &str, folder: &Folder) -> Result<ReadMesh, ReadError> {
    read_attributed_bytes(&gzip::decompress(bytes)?, name.as_ref(), None, folder.clone())
}

fn read_attributed_bytes(
    bytes: &[u8],
    path: &Path,
    format: Option<Format>,
    folder: Folder,
) -> Result<ReadMesh, ReadError> {
    let fetch = |uri: &str| fetch(&folder, uri);
    let read = |format| read_attributed_with(bytes, format, &fetch);
    let mut read = read_as_named_or_shown(bytes, path, format, read, |read| !read.mesh.faces.is_empty())?;
    read.extra.folder = Some(folder);
    Ok(read)
}

/// Returns whether bytes are a glTF, JSON or GLB, gzip-compressed or not.
///
/// ```
/// # use neural_mesh_io as neural_mesh;
/// use neural_mesh::io::is_gltf;
/// assert!(is_gltf(b"glTF\x02\0\0\0") && is_gltf(b" {\"asset\": {}}") && !is_gltf(b"ply\n"));
/// ```
pub fn is_gltf(bytes: &[u8]) -> bool {
    let format = gzip::decompress(bytes).ok().and_then(|bytes| Format::from_content(&bytes));
    matches!(format, Some(Format::Gltf | Format::Glb))
}

/// Returns whether the content of the file at `path` is glTF or GLB.
///
/// Files that cannot be read, and pipes, give false.
///
/// ```
/// # use neural_mesh_io as neural_mesh;
/// use neural_mesh::io::is_gltf_path;
/// assert!(is_gltf_path("../../tests/meshes/tiny/tetrahedron.glb".as_ref()));
/// assert!(!is_gltf_path("no/such/file.glb".as_ref()));
/// ```
pub fn is_gltf_path(path: &Path) -> bool {
    // Reading stops early for large files of other formats.
    let mut first = Vec::new();
    // Only regular files are opened: opening a pipe would consume it.
    let opened = std::fs::File::open(path).ok().filter(|file| file.metadata().is_ok_and(|found| found.is_file()));
    let Some(mut file) = opened.filter(|file| file.take(FIRST).read_to_end(&mut first).is_ok()) else { return false };
    // A compressed file must be unpacked, and the length of the file distinguishes JSON from a binary STL.
    let is_undecided = first.starts_with(b"\x1f\x8b") || !first.starts_with(b"glTF") && is_gltf(&first);
    match is_undecided {
        true => file.read_to_end(&mut first).is_ok() && is_gltf(&first),
        false => first.starts_with(b"glTF"),
    }
}

fn read_decompressed(path: &Path) -> Result<Vec<u8>, ReadError> {
    let bytes = read_file(path)?;
    match gzip::decompress(&bytes)? {
        Cow::Owned(decompressed) => Ok(decompressed),
        Cow::Borrowed(_) => Ok(bytes),
    }
}

// Reads in the given format or that of the name, and if this fails, in the format that the content shows.
fn read_as_named_or_shown<T>(
    bytes: &[u8],
    path: &Path,
    format: Option<Format>,
    read: impl Fn(Option<Format>) -> Result<T, ReadError>,
    is_useful: impl Fn(&T) -> bool,
) -> Result<T, ReadError> {
    // A given format is final; one from the name is only a guess.
    let named = format.or_else(|| Format::from_path(path));
    let first = read(named);
    match Format::from_content(bytes) {
        // The first error is kept if the second try fails as well: it fits the name that the user sees.
        Some(shown) if format.is_none() && named != Some(shown) && !first.as_ref().is_ok_and(is_useful) => {
            read(Some(shown)).or(first)
        }
        _ => first,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_extension_does_not_mislead() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mesh.stl");
        std::fs::write(&path, "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").unwrap();
        assert_eq!(read_path(&path, None).unwrap().faces.len(), 1);
        assert!(read_path(&path, Some(Format::Stl)).is_err());
    }
}
