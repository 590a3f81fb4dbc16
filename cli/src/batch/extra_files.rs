//! Extra files of a batch, mostly textures, which must not replace other files of the batch.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use neural_mesh::io::{FilesRead, OutputFile};

use super::manifest::{BatchFolders, MANIFEST_FILE};
use super::outputs::{LOCK_FILE, fold_case, prepare_path};
use crate::failure::Failure;
use crate::finished_run::write_extra_files;
use crate::names::level_paths;

pub struct ExtraFiles {
    folder: PathBuf,
    /// Paths of all results, the manifest and the lock, case-folded; no extra file may replace them.
    results: HashSet<String>,
    /// Folders that contain `results`, case-folded; no extra file may have such a path.
    folders: HashSet<String>,
    /// Paths of extra files that are already written, case-folded.
    written: Mutex<HashSet<String>>,
    force: bool,
}

impl ExtraFiles {
    pub fn new(folders: &BatchFolders, results: &[PathBuf], force: bool) -> Self {
        let results = results.iter().flat_map(|path| level_paths(path, folders.n_levels));
        let results: Vec<PathBuf> = results.chain([MANIFEST_FILE, LOCK_FILE].map(PathBuf::from)).collect();
        Self {
            folder: folders.folder.clone(),
            folders: results.iter().flat_map(|path| path.ancestors().skip(1)).map(fold_case).collect(),
            results: results.iter().map(|path| fold_case(path)).collect(),
            written: Mutex::default(),
            force,
        }
    }

    /// Writes the extra files of the mesh with this result path, relative to OUTDIR.
    ///
    /// # Errors
    /// If a file would replace a result (nothing is written then) or a different file of another mesh; if writing
    /// fails.
    pub fn write(&self, result: &Path, files: &[OutputFile], read: &FilesRead) -> Result<(), Failure> {
        let parent = result.parent().unwrap_or(Path::new(""));
        let relative_path = |file: &OutputFile| parent.join(&file.path);
        if let Some(taken) = files.iter().map(relative_path).find(|path| self.is_taken(path)) {
            let what = "a texture, material or buffer file of a mesh has the name of a result of the batch: rename one of the two in the input";
            return Err(Failure::in_file(&self.folder.join(taken), what));
        }
        // The lock is held during the writes, so that other threads find these files when they check their own.
        let mut written = self.written.lock().unwrap_or_else(PoisonError::into_inner);
        // Files are written in reverse, since files that others refer to come last in the list.
        for file in files.iter().rev() {
            let path = prepare_path(&self.folder, &relative_path(file))?;
            let is_new = written.insert(fold_case(&relative_path(file)));
            if !is_new && std::fs::read(&path).is_ok_and(|there| there != file.bytes) {
                let what = "two meshes of the batch have different texture, material or buffer files of this name: rename one of these files";
                return Err(Failure::in_file(&path, what));
            }
            write_extra_files(&self.folder.join(parent), std::slice::from_ref(file), read, self.force && is_new)?;
        }
        Ok(())
    }

    /// Returns whether the path is a result, below one, or a folder of one.
    fn is_taken(&self, path: &Path) -> bool {
        self.folders.contains(&fold_case(path)) || path.ancestors().any(|path| self.results.contains(&fold_case(path)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn in_folder(folder: &Path, results: &[PathBuf], force: bool) -> ExtraFiles {
        let (folder, read) = (folder.into(), FilesRead::default());
        ExtraFiles::new(&BatchFolders { folder, n_levels: 0, side_folders: Vec::new(), read }, results, force)
    }

    fn file(path: &str, bytes: &[u8]) -> OutputFile {
        OutputFile { path: path.into(), bytes: bytes.to_vec() }
    }

    #[test]
    fn extra_files_never_replace_results_folders_or_the_manifest() {
        let folder = tempfile::tempdir().unwrap();
        let results = ["a.obj", "deep/b.ply", "c.obj"].map(PathBuf::from);
        let extra_files = in_folder(folder.path(), &results, true);
        let read = FilesRead::default();
        let write = |result: &str, path: &str| {
            extra_files.write(Path::new(result), &[file("t.png", b"t"), file(path, b"x")], &read)
        };
        for path in ["c.obj", "C.OBJ", "c.obj/x.png", "deep", "deep/b.ply", "manifest.csv", "Manifest.CSV"] {
            assert!(write("a.obj", path).is_err(), "{path}");
        }
        assert!(write("deep/b.ply", "b.ply").is_err());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        assert!(write("a.obj", "deep/u.png").is_ok() && write("deep/b.ply", "c.obj").is_ok());
        assert!(folder.path().join("deep/c.obj").is_file());
    }

    #[test]
    fn the_first_mesh_keeps_its_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.png");
        std::fs::write(&path, "of an earlier run").unwrap();
        let write = |extra_files: &ExtraFiles, bytes| {
            extra_files.write(Path::new("a.obj"), &[file("t.png", bytes)], &FilesRead::default())
        };
        let keeping = in_folder(folder.path(), &[], false);
        assert!(write(&keeping, b"mine").is_err());
        let extra_files = in_folder(folder.path(), &[], true);
        assert!(write(&extra_files, b"mine").is_ok() && write(&extra_files, b"mine").is_ok());
        assert!(write(&extra_files, b"yours").is_err());
        assert_eq!(std::fs::read(&path).unwrap(), b"mine");
    }

    #[cfg(unix)]
    #[test]
    fn links_to_other_folders_are_rejected() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("deep")).unwrap();
        std::os::unix::fs::symlink("deep", folder.path().join("maps")).unwrap();
        let extra_files = in_folder(folder.path(), &["a.obj".into(), "deep/b.ply".into()], true);
        assert!(extra_files.write(Path::new("a.obj"), &[file("maps/b.ply", b"x")], &FilesRead::default()).is_err());
        assert_eq!(std::fs::read_dir(folder.path().join("deep")).unwrap().count(), 0);
    }
}
