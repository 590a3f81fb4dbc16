//! The data set of a training.

use super::{Settings, TrainError};
use crate::io::{Format, can_read, read_path};
use crate::mesh::cleanup::{CleanOptions, clean};
use crate::mesh::{InvalidMesh, TriMesh};
use crate::model::normalize_points;
use crate::parallel;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};

/// A mesh of the data set.
#[derive(Clone, Debug, PartialEq)]
pub struct TrainingMesh {
    /// Name of the file.
    pub name: String,
    /// The cleaned mesh, with mean 0 and bounding box diagonal 1.
    pub mesh: TriMesh,
}

/// A mesh file with its checksum, which detects changed data.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct DataFile {
    /// Name of the file.
    pub name: String,
    /// SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
}

/// The meshes of a folder.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DataSet {
    /// Meshes for training.
    pub training: Vec<TrainingMesh>,
    /// Meshes for validation, selected by the beginnings of their names.
    pub validation: Vec<TrainingMesh>,
    /// Names of unused files, each with the reason.
    pub left_out: Vec<(String, String)>,
    /// All mesh files, used or not, by name.
    pub files: Vec<DataFile>,
}

/// Reads every mesh file in a folder, in the order of names.
///
/// # Errors
/// [`TrainError::File`] if the folder cannot be read or has no mesh for training.
///
/// ```
/// use neural_mesh::train::{Settings, read_data};
/// let folder = tempfile::tempdir().unwrap();
/// std::fs::write(folder.path().join("mesh.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
/// let data = read_data(folder.path(), &Settings::from_toml("").unwrap()).unwrap();
/// assert_eq!(data.training[0].name, "mesh.obj");
/// ```
pub fn read_data(folder: &Path, settings: &Settings) -> Result<DataSet, TrainError> {
    let mut data = DataSet::default();
    for read in parallel::each(mesh_files(folder)?, |path| read_file(&path, settings)) {
        let (file, mesh) = read?;
        let name = file.name.clone();
        data.files.push(file);
        match mesh {
            Err(why) => data.left_out.push((name, why)),
            Ok(mesh) if is_for_validation(&name, settings) => data.validation.push(TrainingMesh { name, mesh }),
            Ok(mesh) => data.training.push(TrainingMesh { name, mesh }),
        }
    }
    if data.training.is_empty() {
        let first = data.left_out.first().map(|(name, why)| format!(" (the first of those left out: {name}: {why})"));
        let what = format!("contains no mesh to train on{}: give a folder of mesh files", first.unwrap_or_default());
        return Err(TrainError::file(folder, what));
    }
    Ok(data)
}

pub(super) fn find_changed_file(before: &[DataFile], now: &[DataFile]) -> Option<String> {
    let named = |files: &[DataFile], name: &str| files.iter().find(|file| file.name == name).cloned();
    let lost = before.iter().find_map(|old| match named(now, &old.name) {
        None => Some(format!("the data's file {} is gone", old.name)),
        Some(new) if new != *old => Some(format!("the data's file {} has changed", old.name)),
        Some(_) => None,
    });
    let added = || now.iter().find(|new| named(before, &new.name).is_none());
    lost.or_else(|| added().map(|new| format!("the data's file {} is new", new.name)))
}

pub(super) fn data_table(data: &DataSet) -> String {
    let mut rows = vec!["file,use,vertices,faces,sha256".to_string()];
    for file in &data.files {
        let find = |meshes: &[TrainingMesh]| meshes.iter().find(|mesh| mesh.name == file.name).map(counts);
        let (purpose, counts) = match (find(&data.training), find(&data.validation)) {
            (Some(counts), _) => ("training", counts),
            (None, Some(counts)) => ("validation", counts),
            (None, None) => ("left out", ",".into()),
        };
        rows.push(format!("{},{purpose},{counts},{}", super::csv_table::quote_field(&file.name), file.sha256));
    }
    rows.push(String::new());
    rows.join("\n")
}

fn counts(mesh: &TrainingMesh) -> String {
    format!("{},{}", mesh.mesh.positions().len(), mesh.mesh.faces().len())
}

fn mesh_files(folder: &Path) -> Result<Vec<PathBuf>, TrainError> {
    let problem = |error| TrainError::file(folder, format!("cannot be read: {error}: give a folder of mesh files"));
    let entries = std::fs::read_dir(folder).map_err(problem)?;
    let paths = entries.map(|entry| entry.map(|entry| entry.path())).collect::<Result<Vec<_>, _>>().map_err(problem)?;
    let mut paths: Vec<PathBuf> =
        paths.into_iter().filter(|path| path.is_file() && Format::from_path(path).is_some_and(can_read)).collect();
    paths.sort();
    Ok(paths)
}

fn read_file(path: &Path, settings: &Settings) -> Result<(DataFile, Result<TriMesh, String>), TrainError> {
    let bytes = std::fs::read(path)
        .map_err(|error| TrainError::file(path, format!("cannot be read: {error}: check the file, or remove it")))?;
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok((DataFile { name, sha256: sha256(&bytes) }, read_mesh(path, settings.max_vertices)))
}

fn read_mesh(path: &Path, max_vertices: usize) -> Result<TriMesh, String> {
    let raw = read_path(path, None).map_err(|error| error.to_string())?;
    let mesh = clean(raw, &CleanOptions::default()).map_err(|error| error.to_string())?.mesh;
    match mesh.positions().len() {
        n if max_vertices > 0 && n > max_vertices => Err(format!("has {n} vertices, more than `max_vertices`")),
        _ => to_unit_frame(mesh).map_err(|error| error.to_string()),
    }
}

fn to_unit_frame(mesh: TriMesh) -> Result<TriMesh, InvalidMesh> {
    let (positions, faces) = mesh.into_parts();
    TriMesh::new(normalize_points(&positions), faces)
}

fn is_for_validation(name: &str, settings: &Settings) -> bool {
    settings.validation.iter().any(|beginning| !beginning.is_empty() && name.starts_with(beginning.as_str()))
}

pub(super) fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::write;
    use crate::mesh::{Frame, shapes};

    fn folder(names: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for name in names {
            let bytes = write(&shapes::icosphere(0), &Frame::default(), Format::from_path(name.as_ref()).unwrap());
            std::fs::write(folder.path().join(name), bytes.unwrap()).unwrap();
        }
        folder
    }

    fn names(meshes: &[TrainingMesh]) -> Vec<&str> {
        meshes.iter().map(|mesh| mesh.name.as_str()).collect()
    }

    #[test]
    fn families_go_to_validation_and_broken_files_are_named() {
        let folder = folder(&["rat_pose0.ply", "rat_pose1.obj", "ball.off", "cat.stl"]);
        std::fs::write(folder.path().join("broken.obj"), "v 0 0\n").unwrap();
        std::fs::write(folder.path().join("notes.txt"), "words").unwrap();
        let settings = Settings::from_toml("validation = [\"rat_\", \"dog_\"]").unwrap();
        let data = read_data(folder.path(), &settings).unwrap();
        assert_eq!(names(&data.training), ["ball.off", "cat.stl"]);
        assert_eq!(names(&data.validation), ["rat_pose0.ply", "rat_pose1.obj"]);
        assert_eq!(data.left_out.len(), 1);
        assert!(data.left_out[0].0 == "broken.obj" && data.left_out[0].1.contains("three numbers"));
        assert_eq!(data.files.len(), 5);
        assert_eq!(data_table(&data).lines().nth(1).unwrap().split(',').nth(1), Some("training"));
    }

    #[test]
    fn no_mesh_to_train_on_is_refused() {
        let folder = folder(&["rat.ply"]);
        for text in ["validation = [\"rat\"]", "max_vertices = 5"] {
            let error = read_data(folder.path(), &Settings::from_toml(text).unwrap()).unwrap_err();
            assert!(error.to_string().contains("no mesh to train on"), "{error}");
        }
        assert!(read_data(&folder.path().join("none"), &Settings::from_toml("").unwrap()).is_err());
    }

    #[test]
    fn changes_of_files_are_named() {
        let file = |name: &str, sha256: &str| DataFile { name: name.into(), sha256: sha256.into() };
        let before = [file("a", "1"), file("b", "2")];
        assert_eq!(find_changed_file(&before, &before), None);
        let names = |now: &[DataFile]| find_changed_file(&before, now).unwrap();
        assert!(names(&before[..1]).contains("b is gone"));
        assert!(names(&[file("a", "3"), file("b", "2")]).contains("a has changed"));
        assert!(names(&[&before[..], &[file("c", "2")]].concat()).contains("c is new"));
        assert_eq!(sha256(b"abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    }
}
