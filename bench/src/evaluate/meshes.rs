//! Mesh files of a folder, with checksums.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use neural_mesh::io::{Format, can_read, read_path};
use neural_mesh::mesh::TriMesh;
use neural_mesh::mesh::cleanup::{CleanOptions, clean};
use neural_mesh_cli::shared::Failure;

/// Lists the mesh files of a folder by name; `only` has beginnings of names.
pub(crate) fn mesh_files(folder: &Path, only: &[String]) -> Result<Vec<PathBuf>, Failure> {
    let problem = |error| Failure::in_file(folder, format!("cannot be read: {error}: give a folder of mesh files"));
    let entries = std::fs::read_dir(folder).map_err(problem)?;
    let paths = entries.map(|entry| entry.map(|entry| entry.path())).collect::<Result<Vec<_>, _>>().map_err(problem)?;
    let is_mesh = |path: &PathBuf| path.is_file() && Format::from_path(path).is_some_and(can_read);
    let mut files: Vec<PathBuf> = paths.into_iter().filter(is_mesh).collect();
    files.sort_by_key(|path| file_name(path));
    if files.is_empty() {
        return Err(Failure::in_file(folder, "holds no mesh: give a folder of mesh files"));
    }
    if let Some(prefix) = only.iter().find(|prefix| !files.iter().any(|path| file_name(path).starts_with(*prefix))) {
        return Err(Failure::in_file(folder, format!("no mesh begins with {prefix}: check the names")));
    }
    files.retain(|path| only.is_empty() || only.iter().any(|prefix| file_name(path).starts_with(prefix)));
    Ok(files)
}

pub(super) fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

pub(super) fn read_mesh(path: &Path) -> Result<TriMesh, String> {
    let raw = read_path(path, None).map_err(|error| error.to_string())?;
    clean(raw, &CleanOptions::default()).map(|cleaned| cleaned.mesh).map_err(|error| error.to_string())
}

pub(super) fn checksums(files: &[PathBuf]) -> BTreeMap<String, String> {
    let checksum = |path: &PathBuf| std::fs::read(path).map(|bytes| sha256(&bytes)).unwrap_or_default();
    files.iter().map(|path| (file_name(path), checksum(path))).collect()
}

pub(super) fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}
