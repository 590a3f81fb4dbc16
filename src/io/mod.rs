//! Mesh files: bytes to [`RawMesh`] and back, one file per format.
//!
//! Readers take what can be understood and refuse the rest in one line; what is wrong with the mesh itself is for
//! [`cleanup`](crate::mesh::cleanup) to judge.

mod error;
mod format;
#[cfg(feature = "gltf")]
mod gltf;
#[cfg(not(feature = "gltf"))]
#[path = "no_gltf.rs"]
mod gltf;
mod number;
mod obj;
mod off;
mod output_file;
mod path;
mod ply;
mod points;
mod stl;
mod text;
mod write;

pub use error::{Place, ReadError, WriteError};
pub use format::Format;
#[cfg(feature = "gltf")]
pub use gltf::{Asset, LighterPart, Part, write_gltf};
pub use output_file::{OutputFile, write_files};
pub use path::{read_path, write_path};
pub use points::read_points;

use crate::mesh::{Frame, RawMesh, TriMesh};
use write::Content;

/// Reads a mesh from the bytes of a file, in `format` or in the one that the content shows.
///
/// # Errors
/// [`ReadError`] says in one line what is wrong, where, and what to do.
///
/// ```
/// use neural_mesh::io::{Format, read};
/// let mesh = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", None).unwrap();
/// assert_eq!(mesh.faces, [[0, 1, 2]]);
/// let error = read(b"v 0 0\n", Some(Format::Obj)).unwrap_err();
/// assert!(error.to_string().starts_with("obj: line 1: a vertex needs three numbers"));
/// ```
pub fn read(bytes: &[u8], format: Option<Format>) -> Result<RawMesh, ReadError> {
    read_with(bytes, format, &|uri| {
        let what = format!("the buffer {uri:?} is a file of its own");
        Err(ReadError::file(what, "read the asset by its path or export it as GLB"))
    })
}

/// [`read`], where `fetch` gives the bytes of a file that the asset names.
fn read_with(
    bytes: &[u8],
    format: Option<Format>,
    fetch: &dyn Fn(&str) -> Result<Vec<u8>, ReadError>,
) -> Result<RawMesh, ReadError> {
    let format = format.or_else(|| Format::from_content(bytes)).ok_or_else(|| unknown(bytes))?;
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        return Err(ReadError::file("the text is in UTF-16", "save it as UTF-8 or ASCII"));
    }
    let mesh = match format {
        Format::Obj => obj::read(bytes),
        Format::Ply | Format::PlyAscii => ply::read(bytes),
        Format::Stl | Format::StlAscii => stl::read(bytes),
        Format::Off => off::read(bytes),
        Format::Gltf | Format::Glb => gltf::read(bytes, fetch),
    };
    mesh.map_err(|error| ReadError { format: Some(format), ..error })
}

/// Why bytes of no known format are refused.
fn unknown(bytes: &[u8]) -> ReadError {
    let what = if bytes.is_empty() { "the file is empty" } else { "the content is of no known format" };
    ReadError::file(what, &format!("give a mesh file or name its format, one of {}", Format::NAMES.join(", ")))
}

/// Writes a mesh as the bytes of a file, in the coordinates of `frame`.
///
/// # Errors
/// [`WriteError`] where the format cannot hold the mesh.
///
/// ```
/// use neural_mesh::{io, mesh::{Frame, TriMesh}};
/// let mesh = TriMesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.5, 0.0]], vec![[0, 1, 2]]).unwrap();
/// let text = io::write(&mesh, &Frame::default(), io::Format::Obj).unwrap();
/// assert_eq!(text, b"v 0 0 0\nv 1 0 0\nv 0 0.5 0\nf 1 2 3\n");
/// ```
pub fn write(mesh: &TriMesh, frame: &Frame, format: Format) -> Result<Vec<u8>, WriteError> {
    write_content(&Content::of(mesh, frame), format)
}

/// Writes the faces of a mesh over positions (n_vertices x 3, in the file's coordinates) that are not rounded: those
/// of the original, where every vertex still has one.
///
/// # Errors
/// [`WriteError`] where the format cannot hold the mesh, or where there is not one finite position for each vertex.
///
/// ```
/// use neural_mesh::{io, mesh::TriMesh};
/// let mesh = TriMesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.1, 0.0]], vec![[0, 1, 2]]).unwrap();
/// let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.1000000000000001, 0.0]];
/// let text = io::write_exact(&mesh, positions, io::Format::Obj).unwrap();
/// assert_eq!(text, b"v 0 0 0\nv 1 0 0\nv 0 0.1000000000000001 0\nf 1 2 3\n");
/// ```
pub fn write_exact(mesh: &TriMesh, positions: Vec<[f64; 3]>, format: Format) -> Result<Vec<u8>, WriteError> {
    let finite = positions.iter().flatten().all(|x| x.is_finite());
    if positions.len() != mesh.positions().len() || !finite {
        return Err(WriteError {
            what: "there is not one finite position for each vertex: give the mesh's own".into(),
        });
    }
    write_content(&Content::exact(mesh, positions), format)
}

fn write_content(content: &Content, format: Format) -> Result<Vec<u8>, WriteError> {
    match format {
        Format::Obj => Ok(obj::write(content)),
        Format::Ply => Ok(ply::write_binary(content)),
        Format::PlyAscii => Ok(ply::write_text(content)),
        Format::Stl => stl::write_binary(content),
        Format::StlAscii => stl::write_text(content),
        Format::Off => Ok(off::write(content)),
        Format::Gltf | Format::Glb => gltf::write(content, format),
    }
}
