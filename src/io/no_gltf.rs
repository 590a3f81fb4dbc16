//! Stub of `gltf` for builds without it.

use super::gltf_file::GltfFile;
use super::write::Content;
use super::write_options::WriteOptions;
use super::{Format, ReadError, ReadMesh, WriteError};
use crate::mesh::{Attributes, Look, RawMesh};

pub(super) const MISSING: Option<&str> =
    Some("this build writes no glTF: build with the feature gltf or choose another format");

pub(super) fn read(_: &[u8], _: &dyn Fn(&str) -> Result<Vec<u8>, ReadError>) -> Result<RawMesh, ReadError> {
    Err(ReadError::file("this build reads no glTF", "build with the feature gltf or convert the file"))
}

pub(super) fn read_attributed(
    bytes: &[u8],
    fetch: &dyn Fn(&str) -> Result<Vec<u8>, ReadError>,
) -> Result<ReadMesh, ReadError> {
    read(bytes, fetch).map(|mesh| ReadMesh { mesh, ..ReadMesh::default() })
}

pub(super) fn write(_: &Content, _: Format) -> Result<Vec<u8>, WriteError> {
    Err(WriteError { what: MISSING.unwrap_or_default().into() })
}

pub(super) fn write_attributed(
    content: &Content,
    _: &Attributes,
    _: &[String],
    _: &[Option<String>],
    _: &[Look],
    options: &WriteOptions,
) -> Result<GltfFile, WriteError> {
    let file = |bytes| GltfFile { bytes, images: Vec::new(), n_vertices: content.n_vertices(), notes: Vec::new() };
    write(content, options.format).map(file)
}
