//! Reads mesh files through the library's own readers.

use std::path::Path;

use anyhow::{Context, Result};
use neural_mesh::io::read_path;
use neural_mesh::mesh::cleanup::{CleanOptions, clean};
use neural_mesh::mesh::{RawMesh, TriMesh};

/// The parsed arrays.
pub fn load_raw(path: &Path) -> Result<RawMesh> {
    read_path(path, None).with_context(|| path.display().to_string())
}

/// The mesh, welded and cleaned.
pub fn load(path: &Path) -> Result<TriMesh> {
    Ok(clean(load_raw(path)?, &CleanOptions::default())?.mesh)
}

/// The mesh's name in the tables: its file name without extension, with its folder where that has a name of its own.
pub fn name(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let folder = path.parent().and_then(Path::file_name).unwrap_or_default().to_string_lossy();
    if folder.contains('_') { format!("{stem} ({folder})") } else { stem }
}
