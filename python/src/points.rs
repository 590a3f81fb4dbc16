//! `mesh_points`: a cloud in, a mesh over its points out.

use neural_mesh_cli::embedded;
use pyo3::prelude::*;

use crate::arrays::{array, indices, triples};
use crate::given::Positions;
use crate::heard::heard;

/// A meshed cloud as arrays.
#[pyclass(frozen, get_all, module = "neural_mesh._native")]
pub struct Meshed {
    vertices: Py<PyAny>,
    faces: Py<PyAny>,
    sources: Py<PyAny>,
    report: String,
}

/// Meshes a cloud, or that of the file that the words name.
#[pyfunction]
#[pyo3(signature = (words, points, threads, progress))]
pub fn mesh_points(
    py: Python,
    words: Vec<String>,
    points: Option<Positions>,
    threads: Option<usize>,
    progress: Option<Bound<PyAny>>,
) -> PyResult<Meshed> {
    let given = points.map(|points| points.raw()).transpose()?;
    let meshed =
        heard(py, threads, progress, move |ear| embedded::mesh_points(&words, given, ear.listener(), &|| ear.go_on()))?;
    let (positions, faces) = meshed.mesh.into_parts();
    Ok(Meshed {
        vertices: match meshed.exact {
            Some(exact) => array(py, exact)?,
            None => array(py, positions)?,
        },
        faces: triples(py, faces)?,
        sources: indices(py, meshed.sources)?,
        report: meshed.report,
    })
}
