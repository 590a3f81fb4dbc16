//! What a request names, read from its file or from standard input: meshes, cleaned, and weights.

use std::path::Path;

use neural_mesh::io::{self, Asset, Format, Pieces, ReadError};
use neural_mesh::mesh::RawMesh;
use neural_mesh::mesh::cleanup::{CleanOptions, Cleaned, clean};
use neural_mesh::model::Weights;
use neural_mesh::simplify::Assembly;

use crate::failure::Failure;
use crate::files;
use crate::memory::estimate;
use crate::names::is_stream;
use crate::request::Source;

/// Reads the weights that are given for an assembly, if any are: those that say they learned for the other one are refused.
pub fn read_weights(path: Option<&Path>, assembly: Assembly) -> Result<Option<Weights>, Failure> {
    let Some(path) = path else { return Ok(None) };
    let weights = Weights::from_bytes(&files::read(path)?).map_err(|error| Failure::of(path, error))?;
    let instead = match (weights.objective(), assembly) {
        (Some("paper"), Assembly::Closed) => "--assembly paper alone: add it",
        // What learned nothing worth keeping serves to try out either.
        (None | Some("paper" | "uniform"), _) | (_, Assembly::Closed) => return Ok(Some(weights)),
        (_, Assembly::Paper) => "--assembly closed alone: leave --assembly paper out",
    };
    let learned = weights.objective().unwrap_or_default();
    Err(Failure::of(path, format!("learned the objective \"{learned}\", for {instead}, or leave --weights out")))
}

/// Reads and parses a mesh.
pub fn read(source: &Source) -> Result<RawMesh, Failure> {
    parsed(source, io::read, io::read_path)
}

/// Opens the glTF that the source names, with what it refers to.
pub fn asset(source: &Source) -> Result<Asset, Failure> {
    let asset = match source.content.take(&source.path).transpose()? {
        Some(bytes) => Asset::from_stream(&bytes),
        None => Asset::read_path(&source.path),
    };
    asset.map_err(|error| Failure::of(&source.path, error))
}

/// Parses what the source names: bytes of standard input, or the file at a path.
pub fn parsed<T>(
    source: &Source,
    parse: fn(&[u8], Option<Format>) -> Result<T, ReadError>,
    parse_path: fn(&Path, Option<Format>) -> Result<T, ReadError>,
) -> Result<T, Failure> {
    let bytes = source.content.take(&source.path).transpose()?;
    let parse = |format| match &bytes {
        Some(bytes) => parse(bytes, format),
        None => parse_path(&source.path, format),
    };
    let mesh = match (parse(source.format), source.last_resort) {
        (Err(ReadError { format: None, .. }), Some(format)) => parse(Some(format)),
        (mesh, _) => mesh,
    };
    mesh.map_err(|error| match error.is_of_unknown_format() {
        true => Failure::of(&source.path, format!("{}: {}", error.what, source.remedy)),
        false => Failure::of(&source.path, error),
    })
}

/// A mesh file that takes more memory than is allowed and can be read in pieces, and how much is allowed; what cannot be read so may
/// fit after all.
pub fn in_pieces(path: &Path, allowed: Option<u64>, bake: Option<usize>) -> Option<(Pieces, u64)> {
    let most = allowed.filter(|most| !is_stream(path) && estimate(path, bake) > *most)?;
    Some((Pieces::open(path).ok()?, most))
}

/// Welds and cleans a mesh as read.
pub fn cleaned(raw: RawMesh, source: &Source) -> Result<Cleaned, Failure> {
    let mut options = CleanOptions::default();
    options.weld = source.weld;
    clean(raw, &options).map_err(|error| Failure::of(&source.path, error))
}
