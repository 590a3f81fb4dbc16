//! Outcome of a job.

use crate::io::Packing;
use crate::simplify::Simplified;

use super::baked_material::BakedMaterial;
use super::document::Document;
use super::error::JobError;
use super::files::{Files, Meshes};
use super::report::{JobReport, Level};
use super::request::Job;

/// Area of a square as high as the screen, relative to the screen's area.
const SCREEN: f64 = 9.0 / 16.0;

/// Results of a job and its report.
pub struct JobOutcome {
    /// One result, or one per level of detail.
    pub results: Vec<Simplified>,
    /// Report, completed by [`write`](Self::write).
    pub report: JobReport,
    /// Baked material.
    pub baked: Option<BakedMaterial>,
    pub(super) packing: Option<Packing>,
    // Number of notes in the report that precede the notes of writing.
    pub(super) n_first_notes: usize,
}

impl JobOutcome {
    /// Makes the files, one mesh file per name of the job, and completes the report.
    ///
    /// # Errors
    /// [`JobError::Output`] if the format cannot store a result.
    pub fn write(&mut self, document: &Document, job: &Job) -> Result<Vec<Files>, JobError> {
        let files = self.make_files(document, job)?;
        self.complete_report(&files);
        Ok(files)
    }

    /// Makes the files as [`write`](Self::write) does, for example for another folder; the report stays.
    ///
    /// # Errors
    /// As [`write`](Self::write).
    pub fn make_files(&self, document: &Document, job: &Job) -> Result<Vec<Files>, JobError> {
        let (baked, packing) = (self.baked.as_ref(), self.packing.as_ref());
        let mut meshes = Meshes { results: self.results.iter().collect(), baked, packing, ..Meshes::default() };
        let written = if job.names.are_several() {
            document.to_files_apart(&meshes, job)
        } else {
            if self.results.len() > 1 {
                (meshes.coverage, meshes.distances) = (coverage(&self.report.levels), distances(&self.report.levels));
            }
            document.to_files(&meshes, job, job.names.file(0)).map(|files| vec![files])
        };
        written.map_err(|error| JobError::Output(error.to_string()))
    }

    fn complete_report(&mut self, files: &[Files]) {
        let n_vertices: Vec<Option<usize>> = files.iter().flat_map(|files| files.n_vertices.iter().copied()).collect();
        self.report.output.vertices_written = n_vertices.first().copied().flatten();
        for (level, n) in self.report.levels.iter_mut().zip(n_vertices) {
            level.output.vertices_written = n;
        }
        let notes = files.first().map_or(Vec::new(), |files| files.notes.clone());
        let at = self.n_first_notes.min(self.report.notes.len());
        self.report.notes.splice(at..at, notes);
    }
}

/// Returns the distance from which each level is drawn, which rises from 0; empty without known errors.
fn distances(levels: &[Level]) -> Vec<f64> {
    let coarser = levels.iter().skip(1).map(|level| level.switch_distance);
    let coarser: Option<Vec<f64>> = coarser.collect();
    let rising = |last: &mut f64, distance| {
        *last = last.max(distance);
        Some(*last)
    };
    coarser.map(|them| [0.0].into_iter().chain(them).scan(0.0, rising).collect()).unwrap_or_default()
}

/// Returns the share of the screen's area down to which each level is drawn; empty without known errors.
fn coverage(levels: &[Level]) -> Vec<f64> {
    let area = |level: &Level| level.screen_coverage.map(|height| height * height * SCREEN);
    let next: Option<Vec<f64>> = levels.iter().skip(1).map(area).collect();
    next.map(|next| next.into_iter().chain([0.0]).collect()).unwrap_or_default()
}
