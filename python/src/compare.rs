//! `compare`: figures of results beside their original, and the page that shows them.

use neural_mesh_cli::embedded;
use pyo3::prelude::*;

use crate::given::Given;
use crate::heard::heard;

/// Compares meshes with the first of them; those that are not given are read from the files that the words name. Gives the figures
/// as JSON, and the page where the words ask for it, which is written if `writes`.
#[pyfunction]
#[pyo3(signature = (words, meshes, writes, threads))]
pub fn compare(
    py: Python,
    words: Vec<String>,
    meshes: Vec<Option<Given>>,
    writes: bool,
    threads: Option<usize>,
) -> PyResult<(String, Option<String>)> {
    let read = |mesh: Option<Given>| mesh.map(|mesh| mesh.read()).transpose();
    let given = meshes.into_iter().map(read).collect::<PyResult<Vec<_>>>()?;
    let compared = heard(py, threads, None, move |ear| embedded::compare(&words, given, writes, &|| ear.go_on()))?;
    Ok((compared.figures, compared.page))
}
