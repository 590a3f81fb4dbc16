//! A run that is done but for the last step: its files wait beside their places.

use std::path::{Path, PathBuf};

use neural_mesh::io::{self, OutputFile};

use crate::failure::Failure;
use crate::files::{self, Pending};
use neural_mesh::job::Report;

/// A run of which nothing stands in its place yet.
pub struct Done {
    /// What was done.
    pub report: Report,
    /// What was cleaned, in words.
    pub cleaned: String,
    /// The mesh or the report for standard output, where that is its place.
    pub bytes: Option<Vec<u8>>,
    /// The files.
    pub pending: Vec<Pending>,
    /// Files that belong beside the mesh, and the folder.
    pub beside: Option<(PathBuf, Vec<OutputFile>)>,
    /// Whether existing files are replaced.
    pub force: bool,
}

/// Writes what belongs beside the meshes of a folder.
type WriteBeside<'a> = dyn Fn(&Path, &[OutputFile]) -> Result<(), Failure> + 'a;

impl Done {
    /// Puts all that was made in its place; gives the report, and what was cleaned, in words.
    pub fn put(self) -> Result<(Report, String), Failure> {
        let force = self.force;
        self.put_by(&|folder, beside| write_beside(folder, beside, force), files::place)
    }

    /// As [`Done::put`], by other means.
    pub fn put_by(
        self,
        write_beside: &WriteBeside,
        place: fn(Vec<Pending>) -> Result<(), Failure>,
    ) -> Result<(Report, String), Failure> {
        self.check()?;
        self.bytes.iter().try_for_each(|bytes| files::write_to_stdout(bytes))?;
        self.beside.iter().try_for_each(|(folder, beside)| write_beside(folder, beside))?;
        place(self.pending)?;
        Ok((self.report, self.cleaned))
    }

    /// Refuses a run whose mesh needs a file beside it where another of its results will stand.
    fn check(&self) -> Result<(), Failure> {
        let beside = self.beside.iter().flat_map(|(folder, beside)| beside.iter().map(|file| folder.join(&file.path)));
        for path in beside {
            let place = files::in_own_folder(&path);
            if self.pending.iter().any(|pending| pending.is_at(&place)) {
                let what = "the mesh itself needs a file of this name: choose another name for the result";
                return Err(Failure::of(&path, what));
            }
        }
        Ok(())
    }
}

/// Writes files that belong beside a mesh, as the library does.
pub fn write_beside(folder: &Path, beside: &[OutputFile], force: bool) -> Result<(), Failure> {
    io::write_files(folder, beside, force).map_err(|error| Failure::of(folder, error))
}
