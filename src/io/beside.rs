//! Files that a mesh file names: found, read and listed for the output.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

use super::extra::Extra;
use super::folder::{Folder, Trouble, inner_path};
use super::{ImageMaker, ImageUse, OutputFile};

/// A file that an asset names, with its place in the output.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Found {
    /// Path in the output folder.
    pub place: PathBuf,
    /// Path that it was read from.
    pub source: PathBuf,
    /// Whether the asset must name it by the new path.
    pub moved: bool,
    pub bytes: Arc<[u8]>,
}

impl Found {
    /// Returns the folder that names within the file are relative to.
    pub fn folder(&self) -> &Path {
        let file = if self.moved { &self.source } else { &self.place };
        file.parent().unwrap_or(Path::new(""))
    }
}

/// Finds the files that an asset names; each name is looked up once, each file read once.
pub(super) struct Finder<'a> {
    folder: Option<&'a Folder>,
    allow_outside: bool,
    pub files: Vec<OutputFile>,
    /// Uses of the files that are images.
    images: FxHashMap<PathBuf, ImageUse>,
    /// Converter of the images, if any.
    pub maker: Option<&'a dyn ImageMaker>,
    pub notes: Vec<String>,
    /// Results so far, by folder and name.
    known: FxHashMap<(PathBuf, String), Option<Found>>,
    /// Content of files read so far, by path.
    read: FxHashMap<PathBuf, Arc<[u8]>>,
    said: FxHashSet<String>,
}

impl<'a> Finder<'a> {
    pub fn new(extra: &'a Extra, allow_outside: bool) -> Self {
        Self {
            folder: extra.folder.as_ref(),
            allow_outside,
            files: Vec::new(),
            images: FxHashMap::default(),
            maker: None,
            notes: Vec::new(),
            known: FxHashMap::default(),
            read: FxHashMap::default(),
            said: FxHashSet::default(),
        }
    }

    /// Returns whether `name` is a file in the asset's folder.
    pub fn has(&self, name: &str) -> bool {
        inner_path(Path::new(""), name).zip(self.folder).is_some_and(|(path, folder)| folder.has(&path))
    }

    /// Reads the file `name` that a file in `base` refers to; on failure, adds a note and returns `None`.
    ///
    /// `base` is a folder within that of the asset, or an absolute one.
    pub fn find(&mut self, base: &Path, name: &str) -> Option<Found> {
        let asked = (base.to_path_buf(), name.to_string());
        if let Some(found) = self.known.get(&asked) {
            return found.clone();
        }
        let found = self.look_up(base, name);
        let found = found.map_err(|why| self.note(format!("{name:?} {why}"))).ok();
        self.known.insert(asked, found.clone());
        found
    }

    /// Adds a file to the output, once.
    pub fn list(&mut self, place: &Path, bytes: &[u8]) {
        if self.files.iter().all(|file| file.path != place) {
            self.files.push(OutputFile { path: place.to_path_buf(), bytes: bytes.to_vec() });
        }
    }

    /// Adds an image to the output, once.
    pub fn list_image(&mut self, place: &Path, bytes: &[u8], used: ImageUse) {
        self.list(place, bytes);
        self.images.entry(place.to_path_buf()).or_insert(used);
    }

    /// Returns the files for the output, with converted images.
    pub fn made(self) -> Vec<OutputFile> {
        let Self { mut files, images, maker, .. } = self;
        files.par_iter_mut().for_each(|file| {
            let made = images.get(&file.path).zip(maker).and_then(|(&used, maker)| maker.made(&file.bytes, used));
            made.into_iter().for_each(|bytes| file.bytes = bytes);
        });
        files
    }

    fn note(&mut self, note: String) {
        if self.said.insert(note.clone()) {
            self.notes.push(note);
        }
    }

    fn look_up(&mut self, base: &Path, name: &str) -> Result<Found, String> {
        let folder = self.folder.ok_or("is not copied: the mesh was read without its folder")?;
        let inner = if base.is_absolute() { None } else { inner_path(base, name) };
        let wanted = inner.clone().unwrap_or_else(|| base.join(name.replace('\\', "/")));
        let found = match (self.read(folder, &wanted), inner_path(Path::new(""), name)) {
            // // Many programs look for textures next to the mesh, wherever the library that names them is.
            (Err(Trouble::Missing), Some(from_mesh)) if !base.is_absolute() && from_mesh != wanted => {
                let found = self.read(folder, &from_mesh);
                found.map(|found| (found, Some(from_mesh)))
            }
            (Err(_), _) if inner.is_none() && !self.allow_outside => Err(Trouble::Outside),
            (found, _) => found.map(|found| (found, inner)),
        };
        let ((source, bytes), inner) = found.map_err(|trouble| format!("{trouble}: the name stays"))?;
        let moved = inner.is_none();
        // // A file from outside is placed next to the output.
        let place = inner
            .or_else(|| folder.path_within(&source))
            .or_else(|| Some(self.free_place(source.file_name()?.as_ref(), &bytes)));
        Ok(Found { place: place.ok_or("is no file: the name stays")?, source, moved, bytes })
    }

    /// Reads the file at `path`, relative to `folder`.
    fn read(&mut self, folder: &Folder, path: &Path) -> Result<(PathBuf, Arc<[u8]>), Trouble> {
        let source = folder.source(path, self.allow_outside)?;
        if let Some(bytes) = self.read.get(&source) {
            return Ok((source, bytes.clone()));
        }
        let bytes = folder.read(&source)?;
        self.read.insert(source.clone(), bytes.clone());
        Ok((source, bytes))
    }

    /// Returns the name, with a number in front if another file has it.
    fn free_place(&self, name: &Path, bytes: &[u8]) -> PathBuf {
        let is_taken = |path: &Path| self.files.iter().any(|file| file.path == path && *file.bytes != *bytes);
        let numbered = (1..).map(|n| PathBuf::from(format!("{n}_{}", name.display())));
        std::iter::once(name.to_path_buf()).chain(numbered).find(|path| !is_taken(path)).unwrap_or_default()
    }
}

/// Returns a relative path with forward slashes, as files write it.
pub(super) fn reference(path: &Path) -> String {
    let names: Vec<_> = path.components().map(|part| part.as_os_str().to_string_lossy()).collect();
    names.join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_of_many_names_is_read_once() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("t.png"), b"png").unwrap();
        let extra = Extra { folder: Some(Folder::Disk(folder.path().to_path_buf())), ..Extra::default() };
        let mut finder = Finder::new(&extra, false);
        let first = finder.find(Path::new(""), "t.png").unwrap();
        let other = finder.find(Path::new("maps"), "../t.png").unwrap();
        assert!(Arc::ptr_eq(&first.bytes, &other.bytes));
        std::fs::remove_file(folder.path().join("t.png")).unwrap();
        assert_eq!(finder.find(Path::new(""), "t.png"), Some(first));
        for _ in 0..2 {
            assert_eq!(finder.find(Path::new(""), "gone.png"), None);
        }
        assert_eq!(finder.notes.len(), 1);
    }
}
