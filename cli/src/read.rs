//! What a request names, read from its file or from standard input: meshes, cleaned, and weights.

use std::path::Path;

use neural_mesh::io::{self, Format, ReadError};
use neural_mesh::mesh::RawMesh;
use neural_mesh::mesh::cleanup::{CleanOptions, Cleaned, clean};
use neural_mesh::model::Weights;

use crate::failure::Failure;
use crate::files;
use crate::request::{Source, is_stream};

/// Reads the weights of a network.
pub fn read_weights(path: &Path) -> Result<Weights, Failure> {
    Weights::from_bytes(&files::read(path)?).map_err(|error| Failure::of(path, error))
}

/// Reads and parses a mesh.
pub fn read(source: &Source) -> Result<RawMesh, Failure> {
    parsed(source, io::read, io::read_path)
}

/// Parses what the source names: bytes of standard input, or the file at a path.
pub fn parsed<T>(
    source: &Source,
    parse: fn(&[u8], Option<Format>) -> Result<T, ReadError>,
    parse_path: fn(&Path, Option<Format>) -> Result<T, ReadError>,
) -> Result<T, Failure> {
    let bytes = is_stream(&source.path).then(|| files::read(&source.path)).transpose()?;
    let parse = |format| match &bytes {
        Some(bytes) => parse(bytes, format),
        None => parse_path(&source.path, format),
    };
    let mesh = match (parse(source.format), source.last_resort) {
        (Err(ReadError { format: None, .. }), Some(format)) => parse(Some(format)),
        (mesh, _) => mesh,
    };
    mesh.map_err(|error| Failure::of(&source.path, error))
}

/// Welds and cleans a mesh as read.
pub fn cleaned(raw: RawMesh, source: &Source) -> Result<Cleaned, Failure> {
    clean(raw, &CleanOptions { weld: source.weld }).map_err(|error| Failure::of(&source.path, error))
}
