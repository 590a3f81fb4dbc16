//! Finished run whose results are still temporary files.

use std::path::{Path, PathBuf};

use neural_mesh::io::{self, FilesRead, OutputFile};

use crate::failure::Failure;
use crate::files::{self, PendingFile};
use neural_mesh::job::JobReport;

pub struct FinishedRun {
    pub report: JobReport,
    /// Summary of the cleaning.
    pub cleaned: String,
    pub bytes: Option<Vec<u8>>,
    pub pending: Vec<PendingFile>,
    /// Folder of the result, and extra files to write into it, such as textures.
    pub extra_files: Option<(PathBuf, Vec<OutputFile>)>,
    pub force: bool,
    /// Files that the run has read.
    pub read: FilesRead,
}

type WriteExtraFiles<'a> = dyn Fn(&Path, &[OutputFile]) -> Result<(), Failure> + 'a;

impl FinishedRun {
    /// Moves all results into place; returns the report and the summary of the cleaning.
    pub fn place_results(self) -> Result<(JobReport, String), Failure> {
        let (force, read) = (self.force, self.read.clone());
        self.place_results_with(
            &|folder, extra_files| write_extra_files(folder, extra_files, &read, force),
            files::place_files,
        )
    }

    pub fn place_results_with(
        self,
        write_extra_files: &WriteExtraFiles,
        place_files: fn(Vec<PendingFile>, &FilesRead) -> Result<(), Failure>,
    ) -> Result<(JobReport, String), Failure> {
        self.check_extra_files()?;
        // Nothing is written if one of the files would replace another that was read.
        files::check_pending(&self.pending, &self.read)?;
        self.bytes.iter().try_for_each(|bytes| files::write_to_stdout(bytes))?;
        self.extra_files.iter().try_for_each(|(folder, extra_files)| write_extra_files(folder, extra_files))?;
        place_files(self.pending, &self.read)?;
        Ok((self.report, self.cleaned))
    }

    fn check_extra_files(&self) -> Result<(), Failure> {
        let extra_files = self
            .extra_files
            .iter()
            .flat_map(|(folder, extra_files)| extra_files.iter().map(|file| folder.join(&file.path)));
        for path in extra_files {
            let destination = files::resolve_folder(&path);
            if self.pending.iter().any(|pending| pending.is_at(&destination)) {
                let what = "a texture or material file of the mesh has this name: choose another name for the result";
                return Err(Failure::in_file(&path, what));
            }
        }
        Ok(())
    }
}

pub fn write_extra_files(
    folder: &Path,
    extra_files: &[OutputFile],
    read: &FilesRead,
    force: bool,
) -> Result<(), Failure> {
    let written = read.check_companions(folder, extra_files).and_then(|()| io::write_files(folder, extra_files, force));
    written.map_err(|error| Failure::in_file(folder, error))
}
