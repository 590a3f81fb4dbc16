//! The files that levels of detail go to, and what these share.

use std::path::PathBuf;

use crate::names::{level_paths, with_level, without_level};
use crate::request::Request;

/// What files share whose names say nothing but their level.
const SHARED: &str = "levels";

/// Returns the files of the levels, where levels are asked for and go to files; those of a scene are one file where the name has no
/// place for the level.
fn level_files(request: &Request) -> Option<Vec<PathBuf>> {
    let (path, n_levels) = (request.output.as_ref()?, request.job.goal.n_levels()?);
    let is_scene = request.source.is_scene(request.job.format);
    Some(level_paths(&if is_scene { path.clone() } else { with_level(path) }, n_levels))
}

/// Returns the name after which files are called that levels share, where there are such levels.
pub fn shared_name(request: &Request) -> Option<String> {
    let (path, _) = (request.output.as_deref()?, request.job.goal.n_levels()?);
    Some(without_level(path).unwrap_or_else(|| SHARED.into()))
}

/// Where the mesh goes, or each level of detail; those of a scene are one file where the name has no place for the level.
pub fn outputs(request: &Request) -> Vec<PathBuf> {
    let Some(path) = &request.output else { return Vec::new() };
    level_files(request).unwrap_or_else(|| vec![path.clone()])
}
