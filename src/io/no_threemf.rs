//! Stub of `threemf` for builds without it.

use super::write::Content;
use super::{Extra, ReadError, ReadMesh, WriteError};
use crate::mesh::{Attributes, Look, RawMesh};

pub(super) const MISSING: Option<&str> =
    Some("this build writes no 3MF: build with the feature 3mf or choose another format");

pub(super) fn read(_: &[u8]) -> Result<RawMesh, ReadError> {
    Err(ReadError::file("this build reads no 3MF", "build with the feature 3mf or convert the file"))
}

pub(super) fn read_attributed(bytes: &[u8]) -> Result<ReadMesh, ReadError> {
    read(bytes).map(|mesh| ReadMesh { mesh, ..ReadMesh::default() })
}

pub(super) fn write(_: &Content) -> Result<Vec<u8>, WriteError> {
    Err(WriteError { what: MISSING.unwrap_or_default().into() })
}

pub(super) fn write_attributed(
    content: &Content,
    _: &Attributes,
    _: &Extra,
    _: &[Look],
) -> Result<(Vec<u8>, Vec<String>), WriteError> {
    write(content).map(|bytes| (bytes, Vec::new()))
}
