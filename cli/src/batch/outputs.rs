//! Output paths of a batch.

use std::collections::{HashMap, HashSet};
use std::ffi::OsString;
use std::path::{Component, Path, PathBuf};

use neural_mesh::io::Format;

use super::inputs::Input;
use super::path_text::spell_path;
use crate::failure::Failure;
use crate::names::{file_ending, guess_format, result_format, with_ending, with_level_placeholder};
use crate::request::Source;

pub fn create_folder(folder: &Path) -> Result<PathBuf, Failure> {
    let problem = |error| Failure::in_file(folder, format!("cannot be the output folder: {error}: choose another"));
    std::fs::create_dir_all(folder).map_err(problem)?;
    folder.canonicalize().map_err(problem)
}

/// Returns a distinct path in OUTDIR for each mesh, ignoring case.
///
/// Meshes that would share a name keep their old ending before the new one (`a.obj.ply`), with a number if needed.
pub fn choose_names(inputs: &[Input], format: Option<Format>) -> Vec<PathBuf> {
    let own: Vec<PathBuf> = inputs.iter().map(|input| own_name(input, format)).collect();
    // Some disks ignore case, so names that differ only in case count as equal.
    let mut counts = HashMap::<String, usize>::new();
    for name in &own {
        *counts.entry(fold_case(name)).or_default() += 1;
    }
    let is_shared = |name: &Path| counts.get(&fold_case(name)).is_some_and(|&n| n > 1);
    // Names of a single mesh are taken first; meshes that would share a name all get a longer one.
    let mut taken: HashSet<String> = own.iter().filter(|name| !is_shared(name)).map(|name| fold_case(name)).collect();
    let name =
        |(input, own): (&Input, PathBuf)| if is_shared(&own) { free_name(input, format, &mut taken) } else { own };
    inputs.iter().zip(own).map(name).collect()
}

/// Adds the placeholder `{level}` where each level of detail has its own file.
pub fn with_level_placeholders(inputs: &[Input], names: Vec<PathBuf>, format: Option<Format>) -> Vec<PathBuf> {
    let with_placeholder = |(input, name): (&Input, PathBuf)| {
        let source = Source::new(input.path.clone(), None, true);
        if source.is_scene(format.unwrap_or_else(|| default_format(input))) {
            name
        } else {
            with_level_placeholder(&name)
        }
    };
    inputs.iter().zip(names).map(with_placeholder).collect()
}

fn own_name(input: &Input, format: Option<Format>) -> PathBuf {
    with_ending(&input.relative_path, format.unwrap_or_else(|| default_format(input)))
}

fn free_name(input: &Input, format: Option<Format>, taken: &mut HashSet<String>) -> PathBuf {
    let mut number = 1;
    loop {
        let mut name = OsString::from(input.relative_path.file_name().unwrap_or_default());
        if number > 1 {
            name.push(format!("-{number}"));
        }
        name.push(".");
        name.push(file_ending(format.unwrap_or_else(|| default_format(input))));
        let path = input.relative_path.with_file_name(name);
        if taken.insert(fold_case(&path)) {
            return path;
        }
        number += 1;
    }
}

/// Returns the path in lower case, since some disks ignore case.
pub fn fold_case(path: &Path) -> String {
    spell_path(path).to_lowercase()
}

pub fn default_format(input: &Input) -> Format {
    guess_format(&input.path).map_or(Format::Ply, result_format)
}

/// Creates the folders of a result and returns its path; rejects links, which could lead out of OUTDIR.
pub fn prepare_path(folder: &Path, relative_path: &Path) -> Result<PathBuf, Failure> {
    let mut path = folder.to_path_buf();
    let is_plain = relative_path.components().all(|component| matches!(component, Component::Normal(_)));
    if !is_plain || relative_path.file_name().is_none() {
        return Err(Failure::in_file(relative_path, "would be outside the output folder: rename the mesh"));
    }
    for component in relative_path.parent().into_iter().flat_map(Path::components) {
        path.push(component);
        match std::fs::symlink_metadata(&path) {
            Ok(found) if found.is_dir() => {}
            Ok(_) => {
                return Err(Failure::in_file(
                    &path,
                    "is a file, but the batch needs a folder of this name: move the file away, or choose another output folder",
                ));
            }
            Err(_) => make_folder(&path)?,
        }
    }
    path.push(relative_path.file_name().unwrap_or_default());
    match std::fs::symlink_metadata(&path) {
        Ok(found) if found.is_symlink() => Err(Failure::in_file(
            &path,
            "is a link, which a batch never replaces: move it away, or choose another output folder",
        )),
        _ => Ok(path),
    }
}

/// Creates a folder, unless another thread was faster.
fn make_folder(path: &Path) -> Result<(), Failure> {
    match std::fs::create_dir(path) {
        Err(error) if !path.is_dir() => Err(Failure::in_file(
            path,
            format!("the folder cannot be created: {error}: check the folder above it and the disk"),
        )),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen_names(paths: &[&str], format: Option<Format>) -> Vec<String> {
        let input = |path: &&str| Input { path: path.into(), relative_path: path.into() };
        let inputs: Vec<Input> = paths.iter().map(input).collect();
        choose_names(&inputs, format).iter().map(|name| name.to_string_lossy().into_owned()).collect()
    }

    #[test]
    fn unshared_names_are_kept() {
        assert_eq!(chosen_names(&["a.obj", "a.ply", "b/a.glb"], None), ["a.obj", "a.ply", "b/a.glb"]);
        assert_eq!(chosen_names(&["a.obj", "b.stl"], Some(Format::PlyAscii)), ["a.ply", "b.ply"]);
    }

    #[test]
    fn shared_names_keep_their_old_ending() {
        assert_eq!(chosen_names(&["a.obj", "a.ply"], Some(Format::Ply)), ["a.obj.ply", "a.ply.ply"]);
        assert_eq!(chosen_names(&["A.ply", "a.ply"], None), ["A.ply.ply", "a.ply-2.ply"]);
        // A third mesh has the name that one of the two would get.
        let three = chosen_names(&["a.obj", "a.obj.ply", "a.ply"], Some(Format::Ply));
        assert_eq!(three, ["a.obj-2.ply", "a.obj.ply", "a.ply.ply"]);
    }

    #[test]
    fn paths_outside_the_folder_are_rejected() {
        let folder = tempfile::tempdir().unwrap();
        for path in ["../a.ply", "/a.ply", "b/../../a.ply", ""] {
            assert!(prepare_path(folder.path(), Path::new(path)).is_err(), "{path}");
        }
        assert_eq!(prepare_path(folder.path(), Path::new("b/c/a.ply")).unwrap(), folder.path().join("b/c/a.ply"));
        assert!(folder.path().join("b/c").is_dir());
    }

    #[cfg(unix)]
    #[test]
    fn links_are_not_followed() {
        let (folder, elsewhere) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        std::os::unix::fs::symlink(elsewhere.path(), folder.path().join("b")).unwrap();
        std::os::unix::fs::symlink(elsewhere.path().join("x.ply"), folder.path().join("a.ply")).unwrap();
        assert!(prepare_path(folder.path(), Path::new("b/c/a.ply")).is_err());
        assert!(prepare_path(folder.path(), Path::new("a.ply")).is_err());
        assert_eq!(std::fs::read_dir(elsewhere.path()).unwrap().count(), 0);
    }
}
