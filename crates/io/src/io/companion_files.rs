//! Material libraries and textures that a mesh file names.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use rustc_hash::{FxHashMap, FxHashSet};

use super::extra::Extra;
use super::folder::{FileProblem, Folder, inner_path};
use super::{ImageConverter, ImageUse, OutputFile, OutputFolder, shorten_name};
use crate::parallel;

#[derive(Clone, Debug, PartialEq)]
pub(super) struct CompanionFile {
    pub output_path: PathBuf,
    pub source: PathBuf,
    // True if the output must refer to the file by `output_path` instead of its old name.
    pub is_renamed: bool,
    pub bytes: Arc<[u8]>,
}

impl CompanionFile {
    // Names within the file are relative to this folder.
    pub fn folder(&self) -> &Path {
        let file = if self.is_renamed { &self.source } else { &self.output_path };
        file.parent().unwrap_or(Path::new(""))
    }
}

#[derive(Default)]
pub(super) struct FileFinder<'a> {
    folder: Option<&'a Folder>,
    // Format of the mesh that names the files.
    format: &'static str,
    allow_outside: bool,
    pub files: Vec<OutputFile>,
    // Paths of the files.
    paths: FxHashSet<PathBuf>,
    images: FxHashMap<PathBuf, ImageUse>,
    pub converter: Option<&'a dyn ImageConverter>,
    pub output: Option<&'a OutputFolder>,
    // Names of files that have other ones in the output folder.
    renamed: FxHashMap<PathBuf, PathBuf>,
    pub notes: Vec<String>,
    known: FxHashMap<(PathBuf, String), Option<CompanionFile>>,
    read: FxHashMap<PathBuf, Arc<[u8]>>,
    known_notes: FxHashSet<String>,
}

impl<'a> FileFinder<'a> {
    pub fn new(extra: &'a Extra, allow_outside: bool) -> Self {
        // An OBJ names files in its libraries, a PLY in its comments.
        let format = if extra.material_libraries.is_empty() { "PLY" } else { "OBJ" };
        Self { folder: extra.folder.as_ref(), format, allow_outside, ..Self::default() }
    }

    pub fn has_file(&self, name: &str) -> bool {
        inner_path(Path::new(""), name).zip(self.folder).is_some_and(|(path, folder)| folder.has_file(&path))
    }

    /// Reads the file `name` for a file in the folder `base`; failures add a note.
    pub fn find(&mut self, base: &Path, name: &str) -> Option<CompanionFile> {
        // Failures are remembered as well, so that each is noted once.
        let key = (base.to_path_buf(), name.to_string());
        if let Some(found) = self.known.get(&key) {
            return found.clone();
        }
        let found = self.look_up(base, name);
        let found = found.map_err(|why| self.note(format!("{:?} {why}", shorten_name(name)))).ok();
        self.known.insert(key, found.clone());
        found
    }

    /// Adds a file; returns its path, which differs from `path` if a file there may not change.
    pub fn add_file(&mut self, path: &Path, bytes: &[u8]) -> PathBuf {
        let renamed = || Some(self.output?.free_path(path, bytes, None, &self.files));
        let place = self.renamed.get(path).cloned().or_else(renamed).unwrap_or_else(|| path.into());
        self.renamed.insert(path.into(), place.clone());
        self.push(place.clone(), bytes);
        place
    }

    /// Adds an image, to be converted; returns its path as [`add_file`](Self::add_file) does.
    pub fn add_image(&mut self, path: &Path, bytes: &[u8], used: ImageUse) -> PathBuf {
        if let Some(place) = self.renamed.get(path) {
            return place.clone();
        }
        let mut place = path.to_path_buf();
        if let Some(output) = self.output.filter(|output| output.keeps(path)) {
            // The name depends on the converted bytes, so this image is converted at once.
            let (converted, suffix) = self.converter.map_or((None, None), |it| (it.convert(bytes, used), it.suffix()));
            place = output.free_path(path, converted.as_deref().unwrap_or(bytes), suffix.as_deref(), &self.files);
        }
        self.renamed.insert(path.into(), place.clone());
        self.push(place.clone(), bytes);
        self.images.entry(place.clone()).or_insert(used);
        place
    }

    fn push(&mut self, path: PathBuf, bytes: &[u8]) {
        if self.paths.insert(path.clone()) {
            self.files.push(OutputFile { path, bytes: bytes.to_vec() });
        }
    }

    pub fn into_files(self) -> Vec<OutputFile> {
        let Self { mut files, images, converter, .. } = self;
        // Conversion is slow, and files are independent.
        parallel::each(&mut files, |file| {
            let converted = images
                .get(&file.path)
                .zip(converter)
                .and_then(|(&used, converter)| converter.convert(&file.bytes, used));
            converted.into_iter().for_each(|bytes| file.bytes = bytes);
        });
        files
    }

    fn note(&mut self, note: String) {
        if self.known_notes.insert(note.clone()) {
            self.notes.push(note);
        }
    }

    fn look_up(&mut self, base: &Path, name: &str) -> Result<CompanionFile, String> {
        // A mesh from memory or a stream has no folder to search.
        let folder =
            self.folder.ok_or("is not copied, as the mesh was read without its folder: read it by its path")?;
        let inner = if base.is_absolute() { None } else { inner_path(base, name) };
        let path = inner.clone().unwrap_or_else(|| base.join(name.replace('\\', "/")));
        let found = match (self.read(folder, &path), inner_path(Path::new(""), name)) {
            // Many programs look for textures next to the mesh, wherever the library that names them is.
            (Err(FileProblem::Missing), Some(from_mesh)) if !base.is_absolute() && from_mesh != path => {
                let found = self.read(folder, &from_mesh);
                found.map(|found| (found, Some(from_mesh)))
            }
            (Err(_), _) if inner.is_none() && !self.allow_outside => Err(FileProblem::Outside),
            (found, _) => found.map(|found| (found, inner)),
        };
        let refers = format!("but the {} refers to it", self.format);
        let ((source, bytes), inner) = found.map_err(|problem| match problem {
            FileProblem::Outside => {
                format!("is outside the folder of the mesh: it is not copied without --allow-outside, {refers}")
            }
            problem => format!("{problem}: it is not copied, {refers}"),
        })?;
        // A file from outside cannot keep its path, which would leave the output folder.
        let is_renamed = inner.is_none();
        // A file from outside is placed next to the output.
        let output_path = inner
            .or_else(|| folder.relative_path(&source))
            .or_else(|| Some(self.free_path(source.file_name()?.as_ref(), &bytes)));
        Ok(CompanionFile {
            output_path: output_path.ok_or_else(|| format!("is not a file: it is not copied, {refers}"))?,
            source,
            is_renamed,
            bytes,
        })
    }

    fn read(&mut self, folder: &Folder, path: &Path) -> Result<(PathBuf, Arc<[u8]>), FileProblem> {
        let source = folder.resolve(path, self.allow_outside)?;
        if let Some(bytes) = self.read.get(&source) {
            return Ok((source, bytes.clone()));
        }
        let bytes = folder.read(&source)?;
        self.read.insert(source.clone(), bytes.clone());
        Ok((source, bytes))
    }

    fn free_path(&self, name: &Path, bytes: &[u8]) -> PathBuf {
        // An equal file under this name may be shared.
        let is_taken = |path: &Path| self.files.iter().any(|file| file.path == path && *file.bytes != *bytes);
        let numbered = (1..).map(|n| PathBuf::from(format!("{n}_{}", name.display())));
        std::iter::once(name.to_path_buf()).chain(numbered).find(|path| !is_taken(path)).unwrap_or_default()
    }
}

pub(super) fn to_reference(path: &Path) -> String {
    let names: Vec<_> = path.components().map(|part| part.as_os_str().to_string_lossy()).collect();
    names.join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notes_on_missing_files_name_the_format_that_refers_to_them() {
        let folder = tempfile::tempdir().unwrap();
        let folder = Some(Folder::from_file(&folder.path().join("mesh")));
        for (libraries, format) in [(vec!["gone.mtl".to_string()], "OBJ"), (Vec::new(), "PLY")] {
            let extra = Extra { folder: folder.clone(), material_libraries: libraries, ..Extra::default() };
            let mut finder = FileFinder::new(&extra, false);
            assert_eq!(finder.find(Path::new(""), "gone.mtl"), None);
            let note = format!("\"gone.mtl\" is missing: it is not copied, but the {format} refers to it");
            assert_eq!(finder.notes, [note]);
        }
    }

    #[test]
    fn a_file_of_many_names_is_read_once() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("t.png"), b"png").unwrap();
        let extra = Extra { folder: Some(Folder::from_file(&folder.path().join("mesh"))), ..Extra::default() };
        let mut finder = FileFinder::new(&extra, false);
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
