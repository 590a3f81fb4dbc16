//! Finished run whose results are still temporary files.

use std::path::{Path, PathBuf};

use neural_mesh::io::{self, OutputFile};

use crate::failure::Failure;
use crate::files::{self, Pending};
use neural_mesh::job::JobReport;

pub struct Done {
    pub report: JobReport,
    /// Summary of the cleaning.
    pub cleaned: String,
    pub bytes: Option<Vec<u8>>,
    pub pending: Vec<Pending>,
    /// Folder of the mesh, and further files for it, such as textures.
    pub beside: Option<(PathBuf, Vec<OutputFile>)>,
    pub force: bool,
}

type WriteBeside<'a> = dyn Fn(&Path, &[OutputFile]) -> Result<(), Failure> + 'a;

impl Done {
    /// Moves all results into place; returns the report and the summary of the cleaning.
    pub fn put(self) -> Result<(JobReport, String), Failure> {
        let force = self.force;
        self.put_by(&|folder, beside| write_beside(folder, beside, force), files::place)
    }

    pub fn put_by(
        self,
        write_beside: &WriteBeside,
        place: fn(Vec<Pending>) -> Result<(), Failure>,
    ) -> Result<(JobReport, String), Failure> {
        self.check()?;
        self.bytes.iter().try_for_each(|bytes| files::write_to_stdout(bytes))?;
        self.beside.iter().try_for_each(|(folder, beside)| write_beside(folder, beside))?;
        place(self.pending)?;
        Ok((self.report, self.cleaned))
    }

    fn check(&self) -> Result<(), Failure> {
        let beside = self.beside.iter().flat_map(|(folder, beside)| beside.iter().map(|file| folder.join(&file.path)));
        for path in beside {
            let place = files::in_own_folder(&path);
            if self.pending.iter().any(|pending| pending.is_at(&place)) {
                let what = "a texture or material file of the mesh has this name: choose another name for the result";
                return Err(Failure::in_file(&path, what));
            }
        }
        Ok(())
    }
}

pub fn write_beside(folder: &Path, beside: &[OutputFile], force: bool) -> Result<(), Failure> {
    io::write_files(folder, beside, force).map_err(|error| Failure::in_file(folder, error))
}
