//! Mesh files of a folder, with checksums.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::error::EvaluateError;
use neural_mesh::io::{Format, can_read, read_path};
use neural_mesh::mesh::TriMesh;
use neural_mesh::mesh::cleanup::{CleanOptions, clean};

#[derive(Clone, Debug)]
pub(crate) struct MeshFile {
    pub name: String,
    pub path: PathBuf,
}

pub(crate) fn mesh_files(folder: &Path, only: &[String]) -> Result<Vec<MeshFile>, EvaluateError> {
    let problem = |error| EvaluateError::file(folder, format!("cannot be read: {error}: give a folder of mesh files"));
    let entries = std::fs::read_dir(folder).map_err(problem)?;
    let paths = entries.map(|entry| entry.map(|entry| entry.path())).collect::<Result<Vec<_>, _>>().map_err(problem)?;
    let paths = paths.into_iter().filter(|path| path.is_file() && Format::from_path(path).is_some_and(can_read));
    let mut files: Vec<MeshFile> = paths.filter_map(mesh_file).collect();
    files.sort_by(|a, b| a.name.cmp(&b.name));
    if files.is_empty() {
        return Err(EvaluateError::file(folder, "holds no mesh: give a folder of mesh files"));
    }
    if let Some(prefix) = only.iter().find(|prefix| !files.iter().any(|file| file.name.starts_with(*prefix))) {
        return Err(EvaluateError::file(folder, format!("no mesh begins with {prefix}: check the names")));
    }
    files.retain(|file| only.is_empty() || only.iter().any(|prefix| file.name.starts_with(prefix)));
    Ok(files)
}

fn mesh_file(path: PathBuf) -> Option<MeshFile> {
    let name = path.file_name()?.to_string_lossy().into_owned();
    Some(MeshFile { name, path })
}

pub(super) fn read_mesh(path: &Path) -> Result<TriMesh, String> {
    let raw = read_path(path, None).map_err(|error| error.to_string())?;
    clean(raw, &CleanOptions::default()).map(|cleaned| cleaned.mesh).map_err(|error| error.to_string())
}

pub(super) fn checksums(files: &[MeshFile]) -> BTreeMap<String, String> {
    let of = |file: &MeshFile| std::fs::read(&file.path).map(|bytes| sha256(&bytes)).unwrap_or_default();
    files.iter().map(|file| (file.name.clone(), of(file))).collect()
}

pub(super) fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}
