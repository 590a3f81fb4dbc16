//! Files beside a mesh file: those that it names, found and read by rules that lead nowhere else.

use std::path::{Component, Path, PathBuf};

use super::OutputFile;
use super::extra::Extra;

/// The path that `name` gives in the folder `base`, without upward steps; `None` where it leads out of where `base` starts.
/// Both kinds of slashes part names.
pub(super) fn inner_path(base: &Path, name: &str) -> Option<PathBuf> {
    let name = name.replace('\\', "/");
    if name.contains([':', '\0']) {
        return None;
    }
    let mut path = PathBuf::new();
    for part in base.components().chain(Path::new(&name).components()) {
        match part {
            Component::Normal(name) => path.push(name),
            Component::CurDir => {}
            Component::ParentDir if path.pop() => {}
            _ => return None,
        }
    }
    (!path.as_os_str().is_empty()).then_some(path)
}

/// A file that an asset names, as it will lie beside the output.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Found {
    /// Where, from the folder of the output.
    pub place: PathBuf,
    /// Where it was read.
    pub source: PathBuf,
    /// Whether the name in the asset has to change to `place`.
    pub moved: bool,
    pub bytes: Vec<u8>,
}

impl Found {
    /// The folder from which names within the file count.
    pub fn folder(&self) -> &Path {
        let file = if self.moved { &self.source } else { &self.place };
        file.parent().unwrap_or(Path::new(""))
    }
}

/// Finds the files that an asset names.
pub(super) struct Finder<'a> {
    folder: Option<&'a Path>,
    allow_outside: bool,
    pub files: Vec<OutputFile>,
    pub notes: Vec<String>,
}

impl<'a> Finder<'a> {
    pub fn new(extra: &'a Extra, allow_outside: bool) -> Self {
        Self { folder: extra.folder.as_deref(), allow_outside, files: Vec::new(), notes: Vec::new() }
    }

    /// Whether `name` is a file in the folder of the asset.
    pub fn has(&self, name: &str) -> bool {
        let path = inner_path(Path::new(""), name).zip(self.folder).map(|(path, folder)| in_folder(folder).join(path));
        path.is_some_and(|path| path.is_file())
    }

    /// Reads the file `name` that a file in `base` names, a folder within that of the asset or an outside one; a note
    /// says why there is none.
    pub fn find(&mut self, base: &Path, name: &str) -> Option<Found> {
        let found = self.look_up(base, name);
        found.map_err(|why| self.note(format!("{name:?} {why}"))).ok()
    }

    /// Lists a file for the output, once.
    pub fn list(&mut self, place: &Path, bytes: Vec<u8>) {
        if self.files.iter().all(|file| file.path != place) {
            self.files.push(OutputFile { path: place.to_path_buf(), bytes });
        }
    }

    fn note(&mut self, note: String) {
        if !self.notes.contains(&note) {
            self.notes.push(note);
        }
    }

    fn look_up(&self, base: &Path, name: &str) -> Result<Found, String> {
        let folder = self.folder.ok_or("is not copied: the mesh was read without its folder")?;
        let inner = if base.is_absolute() { None } else { inner_path(base, name) };
        let wanted = inner.clone().unwrap_or_else(|| base.join(name.replace('\\', "/")));
        let found = match (read_beside(folder, &wanted, self.allow_outside), inner_path(Path::new(""), name)) {
            // Many programs look for textures beside the mesh, wherever the library that names them lies.
            (Err(Trouble::Missing), Some(from_mesh)) if !base.is_absolute() && from_mesh != wanted => {
                let found = read_beside(folder, &from_mesh, self.allow_outside);
                found.map(|found| (found, Some(from_mesh)))
            }
            (Err(_), _) if inner.is_none() && !self.allow_outside => Err(Trouble::Outside),
            (found, _) => found.map(|found| (found, inner)),
        };
        let ((source, bytes), inner) = found.map_err(|trouble| format!("{trouble}: the name stays"))?;
        let folder = in_folder(folder);
        let within =
            folder.canonicalize().ok().and_then(|folder| Some(source.strip_prefix(folder).ok()?.to_path_buf()));
        let moved = inner.is_none();
        // What comes from outside lies beside the output itself.
        let place = inner.or(within).or_else(|| Some(self.free_place(source.file_name()?.as_ref(), &bytes)));
        Ok(Found { place: place.ok_or("is no file: the name stays")?, source, moved, bytes })
    }

    /// The name, with a number before it where another file has it already.
    fn free_place(&self, name: &Path, bytes: &[u8]) -> PathBuf {
        let is_taken = |path: &Path| self.files.iter().any(|file| file.path == path && file.bytes != bytes);
        let numbered = (1..).map(|n| PathBuf::from(format!("{n}_{}", name.display())));
        std::iter::once(name.to_path_buf()).chain(numbered).find(|path| !is_taken(path)).unwrap_or_default()
    }
}

/// Why there is no file beside a mesh.
#[derive(Debug)]
pub(super) enum Trouble {
    /// It lies outside of the folder.
    Outside,
    /// It is not there, or its name leads nowhere.
    Missing,
    /// It is a folder or a device.
    NoFile,
    /// It is there and cannot be read.
    Unreadable(std::io::Error),
}

impl std::fmt::Display for Trouble {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Outside => write!(f, "lies outside the folder of the asset and is not read"),
            Self::Missing => write!(f, "is missing"),
            Self::NoFile => write!(f, "is no file"),
            Self::Unreadable(error) => write!(f, "cannot be read ({error})"),
        }
    }
}

/// The file at `path` from `folder` on, where it was found and its bytes: one in the folder or below it, links followed, or any
/// one where that is allowed.
pub(super) fn read_beside(folder: &Path, path: &Path, allow_outside: bool) -> Result<(PathBuf, Vec<u8>), Trouble> {
    let folder = in_folder(folder);
    let inside = folder.canonicalize().map_err(|_| Trouble::Missing)?;
    let source = folder.join(path).canonicalize().map_err(|_| Trouble::Missing)?;
    if !source.starts_with(inside) && !allow_outside {
        return Err(Trouble::Outside);
    }
    if !source.is_file() {
        return Err(Trouble::NoFile);
    }
    let bytes = std::fs::read(&source).map_err(Trouble::Unreadable)?;
    Ok((source, bytes))
}

/// A folder as it can be joined and asked for.
fn in_folder(folder: &Path) -> &Path {
    if folder.as_os_str().is_empty() { Path::new(".") } else { folder }
}

/// A relative path as files name it.
pub(super) fn reference(path: &Path) -> String {
    let names: Vec<_> = path.components().map(|part| part.as_os_str().to_string_lossy()).collect();
    names.join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_down_or_nowhere() {
        let base = Path::new("materials");
        for (name, expected) in [
            ("a.png", Some("materials/a.png")),
            ("./x/a b.png", Some("materials/x/a b.png")),
            ("..\\textures\\a.png", Some("textures/a.png")),
            ("../a.png", Some("a.png")),
            ("../../a.png", None),
            ("x/../../../a.png", None),
            ("/etc/passwd", None),
            ("C:\\a.png", None),
            ("\\\\host\\a.png", None),
            ("..", None),
        ] {
            assert_eq!(inner_path(base, name), expected.map(PathBuf::from), "{name}");
        }
    }
}
