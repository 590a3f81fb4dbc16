//! Mesh files: readers from bytes to [`RawMesh`], and writers back.
//!
//! Readers check the syntax of a file; [`cleanup`](crate::mesh::cleanup) checks the mesh.

mod attributed_writer;
mod companion_files;
mod corner_wedges;
mod distinct_images;
mod error;
mod extra;
#[cfg(any(feature = "gltf", feature = "3mf", feature = "fbx"))]
mod far_from_origin;
#[cfg(feature = "fbx")]
mod fbx;
mod file_fetcher;
mod files_read;
mod folder;
mod format;
mod format_table;
#[cfg(feature = "gltf")]
mod gltf;
mod group_looks;
mod gzip;
mod images;
mod material_libraries;
mod material_writer;
mod memory;
mod number;
mod obj;
mod off;
mod one_line;
mod output_file;
mod packing;
mod pieces;
mod ply;
mod point_cloud;
mod read_path;
mod runs;
mod scalar;
mod spool;
mod stl;
mod stored_precision;
mod text;
mod texture_comments;
#[cfg(feature = "3mf")]
mod threemf;
#[cfg(any(feature = "3mf", feature = "fbx"))]
mod unique_materials;
#[cfg(any(feature = "3mf", feature = "fbx"))]
mod units;
mod uri;
mod write;
mod write_options;
mod write_path;

pub use attributed_writer::{Model, WrittenModel, describe_losses, packing, write_attributed};
use error::UNKNOWN;
pub use error::{FileLocation, ReadError, WriteError};
pub use extra::{Column, ColumnLayout, Extra, Group, ReadMesh};
pub use files_read::{FilesRead, OutputFolder};
pub use folder::Folder;
pub use format::Format;
pub use format_table::{can_read, write_obstacle};
#[cfg(feature = "gltf")]
pub use gltf::{Asset, AssetContents, AssetPart, SceneOptions, SimplifiedPart, write_gltf};
pub use group_looks::read_looks;
pub use images::{ImageConverter, ImageUse};
pub use memory::{read_file, read_stream};
#[doc(hidden)]
pub use one_line::one_line;
pub use one_line::shorten_name;
pub use output_file::{OutputFile, write_files};
pub use packing::{PackOptions, Packing};
pub use pieces::{Pieces, Triangle};
pub use point_cloud::read_points;
pub use read_path::{is_gltf, is_gltf_path, read_attributed_in, read_attributed_path, read_path};
pub use scalar::Scalar;
#[doc(hidden)]
pub use spool::Spool;
pub use write_options::WriteOptions;
pub use write_path::{compress_by_name, write_path};

use crate::mesh::{Attributes, Frame, RawMesh, TriMesh};
use attributed_writer::WriteTask;
use file_fetcher::{FileFetcher, refuse_external_file};
use format_table::FormatRow;
use write::Content;

/// Reads a mesh from the bytes of a file, gzip-compressed or not; without a `format`, the content decides.
///
/// # Errors
/// [`ReadError`] names the problem, its location and a remedy in one line.
///
/// ```
/// # use neural_mesh_io as neural_mesh;
/// use neural_mesh::io::{Format, read};
/// let mesh = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", None).unwrap();
/// assert_eq!(mesh.faces, [[0, 1, 2]]);
/// let error = read(b"v 0 0\n", Some(Format::Obj)).unwrap_err();
/// assert!(error.to_string().starts_with("obj: line 1: a vertex needs three numbers"));
/// ```
pub fn read(bytes: &[u8], format: Option<Format>) -> Result<RawMesh, ReadError> {
    read_with(bytes, format, &refuse_external_file)
}

/// Reads a mesh with its attributes, groups and materials; without a `format`, the content decides.
///
/// A glTF gives the meshes of its default scene as one mesh.
///
/// # Errors
/// As [`read`].
///
/// ```
/// # use neural_mesh_io as neural_mesh;
/// use neural_mesh::io::read_attributed;
/// let text = b"usemtl skin\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.5 0.25\nf 1/1 2/1 3\n";
/// let read = read_attributed(text, None).unwrap();
/// let uv = &read.mesh.attributes.channels[0];
/// assert_eq!(uv.value(read.mesh.attributes.wedges[0][1]), [0.5, 0.25]);
/// assert_eq!(read.extra.groups[0].material.as_deref(), Some("skin"));
/// ```
pub fn read_attributed(bytes: &[u8], format: Option<Format>) -> Result<ReadMesh, ReadError> {
    read_attributed_with(bytes, format, &refuse_external_file)
}

fn read_attributed_with(bytes: &[u8], format: Option<Format>, fetch: &FileFetcher) -> Result<ReadMesh, ReadError> {
    read_by_row(bytes, format, |row, bytes| row.read(bytes, fetch))
}

fn read_with(bytes: &[u8], format: Option<Format>, fetch: &FileFetcher) -> Result<RawMesh, ReadError> {
    read_by_row(bytes, format, |row, bytes| row.read_geometry(bytes, fetch))
}

fn read_by_row<T>(
    bytes: &[u8],
    format: Option<Format>,
    read: impl Fn(&FormatRow, &[u8]) -> Result<T, ReadError>,
) -> Result<T, ReadError> {
    // Decompression comes first: a compressed file shows only its gzip signature.
    let bytes = &gzip::decompress(bytes)?;
    let format = format.or_else(|| Format::from_content(bytes)).ok_or_else(|| unknown_format_error(bytes))?;
    // This is the signature of UTF-16 text; without this check, a reader would complain about the first word.
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        return Err(ReadError::file("the text is in UTF-16", "save it as UTF-8 or ASCII"));
    }
    // Readers do not know which of their names was given, so the format is added here.
    read(format.row(), bytes).map_err(|error| ReadError { format: Some(format), ..error })
}

fn unknown_format_error(bytes: &[u8]) -> ReadError {
    // An empty file has its own remedy; naming a format would not help.
    if bytes.is_empty() {
        return ReadError::file("the file is empty", "give a mesh file");
    }
    ReadError::file(
        UNKNOWN,
        &format!(
            "give OBJ, PLY, STL, OFF, glTF, GLB, 3MF or FBX, or name the format, one of {}",
            Format::NAMES.join(", ")
        ),
    )
}

/// Writes a mesh as the bytes of a file, in the coordinates of `frame`.
///
/// # Errors
/// [`WriteError`] if the format cannot store the mesh.
///
/// ```
/// # use neural_mesh_io as neural_mesh;
/// use neural_mesh::{io, mesh::{Frame, TriMesh}};
/// let mesh = TriMesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.5, 0.0]], vec![[0, 1, 2]]).unwrap();
/// let text = io::write(&mesh, &Frame::default(), io::Format::Obj).unwrap();
/// assert_eq!(text, b"v 0 0 0\nv 1 0 0\nv 0 0.5 0\nf 1 2 3\n");
/// ```
pub fn write(mesh: &TriMesh, frame: &Frame, format: Format) -> Result<Vec<u8>, WriteError> {
    write_content(Content::from_mesh(mesh, frame), format)
}

/// Writes a mesh with these exact positions, n_vertices x 3, in the file's coordinates.
///
/// # Errors
/// [`WriteError`] if the format cannot store the mesh, or a position is missing or not finite.
///
/// ```
/// # use neural_mesh_io as neural_mesh;
/// use neural_mesh::{io, mesh::TriMesh};
/// let mesh = TriMesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.1, 0.0]], vec![[0, 1, 2]]).unwrap();
/// let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.1000000000000001, 0.0]];
/// let text = io::write_exact(&mesh, positions, io::Format::Obj).unwrap();
/// assert_eq!(text, b"v 0 0 0\nv 1 0 0\nv 0 0.1000000000000001 0\nf 1 2 3\n");
/// ```
pub fn write_exact(mesh: &TriMesh, positions: Vec<[f64; 3]>, format: Format) -> Result<Vec<u8>, WriteError> {
    write_content(Content::from_positions(mesh, positions)?, format)
}

fn write_content(content: Content, format: Format) -> Result<Vec<u8>, WriteError> {
    let (extra, options) = (Extra::default(), WriteOptions::new(format, ""));
    let task = WriteTask { content, attributes: Attributes::NONE, extra: &extra, options: &options };
    task.run().map(|written| written.bytes)
}
