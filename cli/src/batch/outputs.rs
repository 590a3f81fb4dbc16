//! Output paths of a batch, and the lock of its folder.

use std::collections::{HashMap, HashSet};
use std::fs::{File, TryLockError};
use std::path::{Component, Path, PathBuf};

use neural_mesh::io::Format;
use neural_mesh::job::Arguments;

use super::inputs::{Input, join_names};
use crate::failure::Failure;
use crate::names::{file_ending, guess_format, result_format, with_ending, with_level_placeholder};
use crate::request::{Source, mark_levels};

/// File that is locked where folders cannot be.
pub const LOCK_FILE: &str = "manifest.lock";

pub fn create_folder(folder: &Path) -> Result<PathBuf, Failure> {
    let problem = |error| Failure::in_file(folder, format!("cannot be the output folder: {error}: choose another"));
    std::fs::create_dir_all(folder).map_err(problem)?;
    folder.canonicalize().map_err(problem)
}

/// Locks the folder against other batches until the returned file is dropped.
///
/// # Errors
/// If another batch holds the lock, or the disk does not support locks.
pub fn lock_folder(folder: &Path) -> Result<File, Failure> {
    let problem = |error| {
        Failure::in_file(folder, format!("cannot be locked against other batches: {error}: choose another folder"))
    };
    #[cfg(unix)]
    let file = File::open(folder);
    #[cfg(not(unix))]
    let file = File::options().create(true).truncate(false).write(true).open(folder.join(LOCK_FILE));
    let file = file.map_err(problem)?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(Failure::in_file(
            folder,
            "another batch writes into this folder: wait for its end, or choose another folder",
        )),
        Err(TryLockError::Error(error)) => Err(problem(error)),
    }
}

/// Returns a distinct path in OUTDIR for each mesh, with `{level}` where each level has its own file.
///
/// With `ignores_case`, paths in lower case are distinct, too.
/// Meshes that would share a name keep their old ending before the new one: `a.obj.ply`.
///
/// # Errors
/// If two meshes would have the same path even then.
pub fn choose_names(
    inputs: &[Input],
    format: Option<Format>,
    options: &Arguments,
    ignores_case: bool,
) -> Result<Vec<PathBuf>, Failure> {
    let key = |path: &Path| if ignores_case { fold_case(path) } else { join_names(path) };
    let (has_levels, mark) = (!options.lods.is_empty(), mark_levels(options.engine));
    let format_of = |input: &Input| format.unwrap_or_else(|| default_format(input));
    let own: Vec<PathBuf> = inputs.iter().map(|input| with_ending(input.name.as_ref(), format_of(input))).collect();
    let mut counts = HashMap::<String, usize>::new();
    own.iter().for_each(|name| *counts.entry(key(name)).or_default() += 1);
    let mut taken = HashSet::new();
    let choose_name = |(input, own): (&Input, PathBuf)| {
        let is_shared = counts.get(&key(&own)).is_some_and(|&n| n > 1);
        let name = if is_shared { format!("{}.{}", input.name, file_ending(format_of(input))).into() } else { own };
        if !taken.insert(key(&name)) {
            let name = name.display();
            let what =
                format!("another mesh has the same result, {name}, or differs only by case: rename one of the two");
            return Err(Failure::in_file(&input.path, what));
        }
        let is_scene = || Source::new(input.path.clone(), None, true).is_scene(format_of(input));
        let is_one_file = || options.shares_file(format_of(input), is_scene());
        Ok(if has_levels && !is_one_file() { with_level_placeholder(&name, mark) } else { name })
    };
    inputs.iter().zip(own).map(choose_name).collect()
}

/// Returns the path in lower case, since some disks ignore case.
pub fn fold_case(path: &Path) -> String {
    join_names(path).to_lowercase()
}

fn default_format(input: &Input) -> Format {
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
        let input = |path: &&str| Input { path: path.into(), name: path.to_string() };
        let inputs: Vec<Input> = paths.iter().map(input).collect();
        choose_names(&inputs, format, &Arguments::default(), true)
            .unwrap()
            .iter()
            .map(|name| name.to_string_lossy().into_owned())
            .collect()
    }

    #[test]
    fn unshared_names_are_kept() {
        assert_eq!(chosen_names(&["a.obj", "a.ply", "b/a.glb"], None), ["a.obj", "a.ply", "b/a.glb"]);
        assert_eq!(chosen_names(&["a.obj", "b.stl"], Some(Format::PlyAscii)), ["a.ply", "b.ply"]);
    }

    #[test]
    fn shared_names_keep_their_old_ending() {
        assert_eq!(chosen_names(&["a.obj", "a.ply"], Some(Format::Ply)), ["a.obj.ply", "a.ply.ply"]);
    }

    #[test]
    fn two_meshes_never_have_one_result() {
        let input = |path: &str| Input { path: path.into(), name: path.into() };
        for names in [["A.ply", "a.ply", "b.ply"], ["a.obj", "a.obj.ply", "a.ply"]] {
            assert!(
                choose_names(&names.map(input), Some(Format::Ply), &Arguments::default(), true).is_err(),
                "{names:?}"
            );
        }
    }

    #[test]
    fn names_that_differ_by_case_are_two_where_the_folder_tells_them_apart() {
        let inputs = ["A.ply", "a.ply"].map(|path| Input { path: path.into(), name: path.into() });
        let names = choose_names(&inputs, Some(Format::Glb), &Arguments::default(), false).unwrap();
        assert_eq!(names, ["A.glb", "a.glb"].map(PathBuf::from));
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
