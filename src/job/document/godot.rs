//! Script for Godot's import of a scene that gives levels of detail their distances.

use std::path::Path;

use crate::io::{OutputFile, OutputFolder};
use crate::job::choices::Engine;
use crate::job::files::Meshes;
use crate::job::request::Job;

// Words of the script that are replaced by the digits of the largest level, and by the distances of all. The extension for
// Blender has the same script, by a link.
const N_DIGITS: &str = "N_DIGITS";
const RANGES: &str = "RANGES_OF_LEVELS";

const SCRIPT: &str = include_str!("levels.gd");

/// Makes `NAME_LODs.gd`, if the job's levels are for Godot and their distances are known.
pub(super) fn godot_script(
    meshes: &Meshes,
    job: &Job,
    (name, folder): (&str, Option<&OutputFolder>),
) -> Option<OutputFile> {
    let distances = &meshes.distances;
    if job.arguments.engine != Some(Engine::Godot) || distances.is_empty() {
        return None;
    }
    let ends = distances.iter().skip(1).chain([&0.0]);
    let ranges: Vec<String> =
        distances.iter().zip(ends).map(|(begin, end)| format!("[{:?}, {:?}]", *begin as f32, *end as f32)).collect();
    let n_digits = (distances.len() - 1).to_string().len().to_string();
    let bytes = SCRIPT.replace(RANGES, &ranges.join(", ")).replace(N_DIGITS, &n_digits).into_bytes();
    let stem = Path::new(name).file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let path = Path::new(&format!("{stem}_LODs.gd")).to_path_buf();
    let path = folder.map_or(path.clone(), |folder| folder.free_path(&path, &bytes, None, &[]));
    Some(OutputFile { path, bytes })
}
