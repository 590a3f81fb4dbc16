//! Levels of scenes in formats that hold one mesh: the nodes' transforms move into the positions.

use crate::io::{self, Asset, Format, SceneOptions, SimplifiedPart, WriteError};
use crate::job::files::{Files, Meshes};
use crate::job::request::Job;
use crate::simplify::Simplified;

use super::Document;

/// Writes a simplified scene as one mesh, as a file of the scene would be read and written.
pub(super) fn flat_files(
    asset: &Asset,
    (parts, result): (Vec<SimplifiedPart>, &Simplified),
    job: &Job,
    file_name: &str,
) -> Result<Files, WriteError> {
    // A GLB has all that the scene carries, and its reader is the one that places nodes.
    let scene = asset.write_scene(&[&parts], &SceneOptions::new(Format::Glb, file_name))?;
    let bytes = scene.first().map_or(&[][..], |file| file.bytes.as_slice());
    let read = io::read_attributed(bytes, Some(Format::Glb)).map_err(|error| refuse(&error))?;
    let flat = Document::from_mesh(read, job).map_err(|error| refuse(&error))?;
    let mut level = result.clone();
    (level.mesh, level.attributes) = (flat.mesh().clone(), flat.input().attributes.clone());
    (level.source_vertices, level.map) = (None, None);
    flat.to_files(&Meshes { results: vec![&level], ..Meshes::default() }, job, file_name)
}

fn refuse(error: &dyn std::fmt::Display) -> WriteError {
    WriteError::new(error.to_string())
}
