//! A finished run whose results are temporary files that still have to be moved into place.

use std::path::{Path, PathBuf};

use neural_mesh::io::{self, OutputFile};

use crate::failure::Failure;
use crate::files::{self, Pending};
use neural_mesh::job::Report;

/// A finished run before its results are in place.
pub struct Done {
    /// Report of the run.
    pub report: Report,
    /// Summary of what was cleaned.
    pub cleaned: String,
    /// Bytes of the mesh or report for standard output.
    pub bytes: Option<Vec<u8>>,
    /// Files to move into place.
    pub pending: Vec<Pending>,
    /// Folder of the mesh, and the extra files it needs there, such as textures.
    pub beside: Option<(PathBuf, Vec<OutputFile>)>,
    /// Whether existing files are replaced.
    pub force: bool,
}

/// Function that writes the extra files of a mesh into its folder.
type WriteBeside<'a> = dyn Fn(&Path, &[OutputFile]) -> Result<(), Failure> + 'a;

impl Done {
    /// Moves all results into place and returns the report and the summary of what was cleaned.
    pub fn put(self) -> Result<(Report, String), Failure> {
        let force = self.force;
        self.put_by(&|folder, beside| write_beside(folder, beside, force), files::place)
    }

    /// Moves all results into place with the given functions.
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

    /// Rejects a run where an extra file of the mesh has the name of another result.
    fn check(&self) -> Result<(), Failure> {
        let beside = self.beside.iter().flat_map(|(folder, beside)| beside.iter().map(|file| folder.join(&file.path)));
        for path in beside {
            let place = files::in_own_folder(&path);
            if self.pending.iter().any(|pending| pending.is_at(&place)) {
                let what = "the mesh itself needs a file of this name: choose another name for the result";
                return Err(Failure::in_file(&path, what));
            }
        }
        Ok(())
    }
}

pub fn write_beside(folder: &Path, beside: &[OutputFile], force: bool) -> Result<(), Failure> {
    io::write_files(folder, beside, force).map_err(|error| Failure::in_file(folder, error))
}
