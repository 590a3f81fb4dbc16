//! Progressions.

use std::sync::Arc;

use neural_mesh::job::Arguments;
use neural_mesh_cli::embedded::{Files, OpenProgression};
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::background::run_in_background;
use crate::mesh_arrays::{MeshArrays, parse_options};
use crate::simplify::{Outcome, read_input};

#[pyclass(frozen, module = "neural_mesh._native")]
pub struct Progression(Arc<OpenProgression>);

/// Makes the progression of a mesh, of a file in memory, or of the input file.
#[pyfunction]
#[pyo3(signature = (options, files, mesh, file, importance, prove, threads, progress))]
#[allow(clippy::too_many_arguments, reason = "they are what Python has")]
pub fn progression(
    py: Python,
    options: &Bound<PyAny>,
    files: &Bound<PyAny>,
    mesh: Option<MeshArrays>,
    file: Option<(Vec<u8>, String)>,
    importance: Option<PyReadonlyArray1<f32>>,
    prove: bool,
    threads: Option<usize>,
    progress: Option<Bound<PyAny>>,
) -> PyResult<Progression> {
    let (options, files): (Arguments, Files) = (parse_options(options)?, parse_options(files)?);
    let given = read_input(mesh, file, importance)?;
    let made = run_in_background(py, threads, progress, move |channel| {
        OpenProgression::new(options, &files, given, prove, channel.listener())
    })?;
    Ok(Progression(Arc::new(made)))
}

/// Opens the bytes of a progression.
#[pyfunction]
pub fn read_progression(py: Python, bytes: Vec<u8>) -> PyResult<Progression> {
    let read = run_in_background(py, None, None, move |_| OpenProgression::from_bytes(&bytes))?;
    Ok(Progression(Arc::new(read)))
}

#[pymethods]
impl Progression {
    /// Makes a level.
    #[pyo3(signature = (options, files, threads))]
    fn level(
        &self,
        py: Python,
        options: &Bound<PyAny>,
        files: &Bound<PyAny>,
        threads: Option<usize>,
    ) -> PyResult<Outcome> {
        let (options, files): (Arguments, Files) = (parse_options(options)?, parse_options(files)?);
        let progression = self.0.clone();
        let outcome = run_in_background(py, threads, None, move |channel| {
            progression.level(options, &files, channel.listener(), &|| channel.check_cancelled())
        })?;
        Outcome::new(py, outcome)
    }

    /// Writes the progression to a file.
    fn save(&self, py: Python, path: std::path::PathBuf, force: bool) -> PyResult<()> {
        let progression = self.0.clone();
        run_in_background(py, None, None, move |_| progression.save(&path, force))
    }

    fn to_bytes(&self, py: Python) -> Py<PyBytes> {
        let bytes = self.0.progression().map_or_else(Vec::new, |progression| progression.to_bytes());
        PyBytes::new(py, &bytes).unbind()
    }

    /// Returns the numbers of vertices and faces of the finest level.
    #[getter]
    fn size(&self) -> (usize, usize) {
        self.0.progression().map_or((0, 0), |progression| (progression.n_vertices(), progression.n_faces()))
    }

    /// Returns vertices and proved distance of each proved level.
    #[getter]
    fn proved_levels(&self) -> Vec<(usize, f64)> {
        let levels = self.0.progression().map_or(&[][..], |progression| progression.proved_levels());
        levels.iter().map(|level| (level.n_vertices, level.distance)).collect()
    }
}
