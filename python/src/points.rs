//! `mesh_points`: meshes a point cloud.

use std::path::PathBuf;

use neural_mesh::job;
use neural_mesh_cli::embedded::{self, MeshPointsArgs, MeshPointsOutput};
use pyo3::prelude::*;

use crate::arrays::{array, indices, triples};
use crate::background::run_in_background;
use crate::failure::option_error;
use crate::mesh_arrays::Positions;

#[pyclass(frozen, get_all, module = "neural_mesh._native")]
pub struct Meshed {
    vertices: Py<PyAny>,
    faces: Py<PyAny>,
    sources: Py<PyAny>,
    report: String,
}

#[derive(FromPyObject)]
pub enum NumberOrText {
    Number(f64),
    Text(String),
}

impl NumberOrText {
    fn read<T>(self, option: &str, read: fn(&str) -> Result<T, String>) -> PyResult<T> {
        let text = match self {
            Self::Number(number) => number.to_string(),
            Self::Text(text) => text,
        };
        read(&text).map_err(|why| option_error(format!("{option}={text}: {why}")))
    }
}

/// Meshes the given point cloud, or that in the file `input`.
#[pyfunction]
#[pyo3(signature = (input, points, *, ratio, vertices, keep_points, out, format, weights, seed, force, threads, progress))]
#[allow(clippy::too_many_arguments, reason = "they are keywords")]
pub fn mesh_points(
    py: Python,
    input: PathBuf,
    points: Option<Positions>,
    ratio: Option<NumberOrText>,
    vertices: Option<NumberOrText>,
    keep_points: bool,
    out: Option<PathBuf>,
    format: Option<String>,
    weights: Option<PathBuf>,
    seed: u64,
    force: bool,
    threads: Option<usize>,
    progress: Option<Bound<PyAny>>,
) -> PyResult<Meshed> {
    let args = MeshPointsArgs {
        input,
        ratio: ratio.map(|ratio| ratio.read("ratio", job::share)).transpose()?,
        vertices: vertices.map(|vertices| vertices.read("vertices", job::vertices)).transpose()?,
        format: format.or(out.is_none().then(|| "ply".into())),
        output: out.unwrap_or("-".into()),
        keep_points,
        weights,
        seed,
        threads: None,
        report: None,
        quiet: true,
        force,
    };
    let given = points.map(|points| points.raw()).transpose()?;
    let meshed = run_in_background(py, threads, progress, move |channel| {
        embedded::mesh_points(args, given, channel.listener(), &|| channel.check_cancelled())
    })?;
    Meshed::new(py, meshed)
}

impl Meshed {
    fn new(py: Python, meshed: MeshPointsOutput) -> PyResult<Self> {
        let (positions, faces) = meshed.mesh.into_parts();
        Ok(Self {
            vertices: match meshed.exact {
                Some(exact) => array(py, exact)?,
                None => array(py, positions)?,
            },
            faces: triples(py, faces)?,
            sources: indices(py, meshed.sources)?,
            report: meshed.report,
        })
    }
}
