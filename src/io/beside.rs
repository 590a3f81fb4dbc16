//! Files beside a mesh file: those that it names, found and read by rules that lead nowhere else.

use std::path::{Component, Path, PathBuf};

use super::OutputFile;
use super::extra::Extra;

/// The path that `name` gives in the folder `base`, without upward steps; `None` where it leads out of where `base` starts.
/// Both kinds of slashes part names.
fn inner_path(base: &Path, name: &str) -> Option<PathBuf> {
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
        let folder = in_folder(self.folder.ok_or("is not copied: the mesh was read without its folder")?);
        let inner = if base.is_absolute() { None } else { inner_path(base, name) };
        let wanted = match &inner {
            Some(inner) => folder.join(inner),
            None => folder.join(base).join(name.replace('\\', "/")),
        };
        let is_inside = is_within(&wanted, folder);
        if !is_inside && !self.allow_outside && (inner.is_none() || wanted.exists()) {
            return Err("lies outside the folder of the asset: the name stays, the file is not copied".into());
        }
        let source = wanted.canonicalize().map_err(|_| "is missing: the name stays")?;
        if !source.is_file() {
            return Err("is no file: the name stays".into());
        }
        let bytes = std::fs::read(&source).map_err(|error| format!("cannot be read ({error}): the name stays"))?;
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

/// Whether a path, links followed, lies in a folder or is it.
fn is_within(path: &Path, folder: &Path) -> bool {
    let ends = path.canonicalize().ok().zip(folder.canonicalize().ok());
    ends.is_some_and(|(path, folder)| path.starts_with(folder))
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
