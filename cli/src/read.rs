//! Reading of meshes and weights.

use std::path::Path;
use std::sync::Arc;

use neural_mesh::io::{Asset, Format, Pieces, ReadError};
use neural_mesh::mesh::RawMesh;
use neural_mesh::mesh::cleanup::{CleanOptions, Cleaned, clean};
use neural_mesh::model::Weights;
use neural_mesh::simplify::Assembly;

use crate::failure::Failure;
use crate::files;
use crate::memory::estimate_bytes;
use crate::names::is_stream;
use crate::request::Source;

/// Reads the given weights; rejects weights trained for the other assembly.
pub fn read_weights(path: Option<&Path>, assembly: &Assembly) -> Result<Option<Arc<Weights>>, Failure> {
    let Some(path) = path else { return Ok(None) };
    let weights = Weights::from_bytes(&files::read(path)?).map_err(|error| Failure::in_file(path, error))?;
    let usage = match (weights.objective(), assembly) {
        (Some("paper"), Assembly::Closed(_)) => "--assembly paper: add that option",
        // Weights that name no objective suit both assemblies.
        (None | Some("paper"), _) | (_, Assembly::Closed(_)) => return Ok(Some(Arc::new(weights))),
        (_, Assembly::Paper(_)) => "--assembly closed: leave --assembly paper out",
    };
    let learned = weights.objective().unwrap_or_default();
    Err(Failure::in_file(
        path,
        format!("was trained with the objective \"{learned}\" and works only with {usage}, or leave --weights out"),
    ))
}

pub fn read_asset(source: &Source) -> Result<Asset, Failure> {
    let asset = match source.content.take(&source.path).transpose()? {
        Some(bytes) => Asset::from_stream(&bytes),
        None => Asset::read_path(&source.path),
    };
    asset.map_err(|error| Failure::in_file(&source.path, error))
}

pub fn parse_source<T>(
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
        true => Failure::in_file(&source.path, format!("{}: {}", error.what, source.remedy)),
        false => Failure::in_file(&source.path, error),
    })
}

/// Opens a mesh file in pieces if it needs more than `allowed` bytes of memory; also returns that bound.
pub fn open_in_pieces(path: &Path, allowed: Option<u64>, bake: Option<usize>) -> Option<(Pieces, u64)> {
    let most = allowed.filter(|most| !is_stream(path) && estimate_bytes(path, bake) > *most)?;
    Some((Pieces::open(path).ok()?, most))
}

pub fn clean_mesh(raw: RawMesh, source: &Source) -> Result<Cleaned, Failure> {
    let mut options = CleanOptions::default();
    options.weld = source.weld;
    clean(raw, &options).map_err(|error| Failure::in_file(&source.path, error))
}
