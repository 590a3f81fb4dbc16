//! Meshes of a batch, from folders, patterns and lists.

use std::path::{Component, Path, PathBuf};

use neural_mesh::io::{Format, can_read};

use crate::args::SimplifyArgs;
use crate::failure::{Failure, display_path};
use crate::files;
use crate::names::{is_stream, list_readable_formats};

#[derive(Debug, PartialEq)]
pub struct Input {
    pub path: PathBuf,
    /// Path relative to the common folder of all inputs, without `..`, with `/` between names.
    pub name: String,
}

/// Joins the names of a path by `/`.
pub fn join_names(path: &Path) -> String {
    path.iter().map(|name| name.to_string_lossy()).collect::<Vec<_>>().join("/")
}

pub fn is_pattern(path: &Path) -> bool {
    !path.exists() && path.to_string_lossy().contains(['*', '?', '['])
}

/// Rejects misplaced option values among the inputs, and a mesh file as the output folder.
pub fn check_arguments(args: &SimplifyArgs) -> Result<(), Failure> {
    let is_value = |text: &str| text.ends_with('%') || text.parse::<f64>().is_ok();
    let stray = args.inputs.iter().find(|path| !path.exists() && path.to_str().is_some_and(is_value));
    if let Some(stray) = stray {
        let what =
            "no such file: if it belongs to an option, write --prune=1% instead of --prune 1%, and 10% instead of 10 %";
        return Err(Failure::Usage(format!("{}: {what}", stray.display())));
    }
    if Format::from_path(&args.output).is_some() && !args.output.is_dir() {
        let what = "is a file name, but several meshes need a folder: give a folder to -o, or only one mesh";
        return Err(Failure::Usage(format!("{}: {what}", args.output.display())));
    }
    Ok(())
}

/// Finds all meshes, each once, ordered by path.
pub fn find_meshes(args: &SimplifyArgs) -> Result<Vec<Input>, Failure> {
    let given = match &args.list {
        Some(list) => read_list(list)?,
        None => args.inputs.clone(),
    };
    let out = normalize_path(&args.output);
    let mut paths = Vec::new();
    for path in &given {
        match path {
            _ if path.is_dir() => collect_meshes(path, &out, &mut paths)?,
            _ if is_pattern(path) => match_pattern(path, &out, &mut paths)?,
            _ => paths.push(path.clone()),
        }
    }
    // Results get the inputs' paths relative to the given folder if it is the only input, else to the deepest common
    // folder.
    let root = match given.as_slice() {
        [only] if only.is_dir() => normalize_path(only),
        _ => common_folder(&paths),
    };
    let inputs: Result<Vec<Input>, Failure> = paths.into_iter().map(|path| create_input(path, &root)).collect();
    let mut inputs = inputs?;
    inputs.sort_by(|a, b| Path::new(&a.name).cmp(Path::new(&b.name)));
    inputs.dedup_by(|a, b| a.name == b.name);
    if inputs.is_empty() {
        let given: Vec<String> = given.iter().map(|path| display_path(path)).collect();
        let what = format!("{}: no mesh files found: {}", given.join(", "), list_readable_formats());
        return Err(Failure::Failed(what));
    }
    Ok(inputs)
}

fn read_list(list: &Path) -> Result<Vec<PathBuf>, Failure> {
    let bytes = files::read(list)?;
    let text = String::from_utf8(bytes)
        .map_err(|_| Failure::in_file(list, "is not text in UTF-8: save it as UTF-8, with one path on each line"))?;
    let paths: Vec<PathBuf> =
        text.lines().map(str::trim_end).filter(|line| !line.is_empty()).map(PathBuf::from).collect();
    match paths.iter().find(|path| is_stream(path)) {
        Some(_) => {
            Err(Failure::in_file(list, "has a line - for standard input: give only files, folders and patterns"))
        }
        None => Ok(paths),
    }
}

/// Collects the mesh files of a folder and its subfolders, without hidden ones, OUTDIR, and links to folders.
fn collect_meshes(folder: &Path, out: &Path, found: &mut Vec<PathBuf>) -> Result<(), Failure> {
    let problem = |error| Failure::in_file(folder, format!("cannot be read: {error}: check the folder"));
    for entry in std::fs::read_dir(folder).map_err(problem)? {
        let entry = entry.map_err(problem)?;
        let (path, kind) = (entry.path(), entry.file_type().map_err(problem)?);
        // Hidden files are no input.
        if entry.file_name().to_string_lossy().starts_with('.') {
            continue;
        }
        // Links to folders are no folders here, and results of an earlier run in OUTDIR are no input.
        match kind.is_dir() {
            true if normalize_path(&path) != out => collect_meshes(&path, out, found)?,
            false if is_mesh(&path) => found.push(path),
            _ => {}
        }
    }
    Ok(())
}

fn match_pattern(pattern: &Path, out: &Path, found: &mut Vec<PathBuf>) -> Result<(), Failure> {
    let problem = |error: &dyn std::fmt::Display| {
        Failure::Usage(format!("{}: {error}: correct the pattern", display_path(pattern)))
    };
    let paths = glob::glob(&pattern.to_string_lossy()).map_err(|error| problem(&error))?;
    let paths = paths.flatten().filter(|path| is_mesh(path) && !normalize_path(path).starts_with(out));
    found.extend(paths);
    Ok(())
}

fn is_mesh(path: &Path) -> bool {
    Format::from_path(path).is_some_and(can_read) && path.is_file()
}

fn create_input(path: PathBuf, root: &Path) -> Result<Input, Failure> {
    let absolute = normalize_path(&path);
    let below = absolute.strip_prefix(root).unwrap_or(&absolute);
    let below: PathBuf = below.components().filter(|component| matches!(component, Component::Normal(_))).collect();
    // A name in the manifest must be that of one mesh.
    match below.to_str() {
        Some(_) => Ok(Input { path, name: join_names(&below) }),
        None => Err(Failure::in_file(&path, "has a name that is not UTF-8: rename it, for the rows of manifest.csv")),
    }
}

fn common_folder(paths: &[PathBuf]) -> PathBuf {
    let folder = |path: &PathBuf| normalize_path(path).parent().map(Path::to_path_buf).unwrap_or_default();
    let common = |a: PathBuf, b: PathBuf| -> PathBuf {
        a.components().zip(b.components()).take_while(|(a, b)| a == b).map(|(a, _)| a).collect()
    };
    paths.iter().map(folder).reduce(common).unwrap_or_default()
}

/// Returns the absolute path without `.` and `..`, from the names alone.
fn normalize_path(path: &Path) -> PathBuf {
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let mut normal = PathBuf::new();
    for component in absolute.components() {
        match component {
            Component::ParentDir => drop(normal.pop()),
            Component::CurDir => {}
            component => normal.push(component),
        }
    }
    normal
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relative_paths_have_no_parent_folders() {
        for (path, root, name) in
            [("/a/b/c.ply", "/a", "b/c.ply"), ("/a/../x/c.ply", "/a", "x/c.ply"), ("/x/c.ply", "/", "x/c.ply")]
        {
            assert_eq!(create_input(path.into(), Path::new(root)).unwrap().name, name, "{path}");
        }
    }

    #[test]
    fn the_common_folder_is_the_deepest() {
        let folder = |paths: &[&str]| common_folder(&paths.iter().map(PathBuf::from).collect::<Vec<_>>());
        assert_eq!(folder(&["/a/b/c.ply", "/a/bc/d.ply"]), Path::new("/a"));
        assert_eq!(folder(&["/a/b/c.ply", "/a/b/d/../d.ply"]), Path::new("/a/b"));
        assert_eq!(folder(&["/a/b.ply"]), Path::new("/a"));
    }
}
