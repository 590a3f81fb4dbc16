//! `simplify` and levels of detail.

use neural_mesh::job::Arguments;
use neural_mesh::mesh::Attributes;
use neural_mesh::simplify::Map;
use neural_mesh_cli::embedded::{self, Files};
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::arrays::{array, indices, numbers, table, triples};
use crate::background::run_in_background;
use crate::mesh_arrays::{MeshArrays, parse_options, role_name};
use crate::values;

#[pyclass(frozen, get_all, module = "neural_mesh._native")]
pub struct Outcome {
    results: Vec<Py<ResultArrays>>,
    report: Py<PyAny>,
    cleaned: String,
    file_vertices: Option<Py<PyAny>>,
    group_names: Vec<(String, u32)>,
    paths: Vec<String>,
    bytes: Option<Py<PyBytes>>,
    unmet: Option<String>,
}

#[pyclass(frozen, get_all, module = "neural_mesh._native")]
pub struct ResultArrays {
    vertices: Py<PyAny>,
    faces: Py<PyAny>,
    wedges: Option<Py<PyAny>>,
    channels: Vec<(String, String, Py<PyAny>)>,
    groups: Option<Py<PyAny>>,
    sources: Option<Py<PyAny>>,
    map: Option<MapArrays>,
}

/// Simplifies a mesh, a file in memory, or the input file.
#[pyfunction]
#[pyo3(signature = (options, files, mesh, file, importance, threads, progress))]
#[allow(clippy::too_many_arguments, reason = "they are what Python has")]
pub fn simplify(
    py: Python,
    options: &Bound<PyAny>,
    files: &Bound<PyAny>,
    mesh: Option<MeshArrays>,
    file: Option<(Vec<u8>, String)>,
    importance: Option<PyReadonlyArray1<f32>>,
    threads: Option<usize>,
    progress: Option<Bound<PyAny>>,
) -> PyResult<Outcome> {
    let (options, files): (Arguments, Files) = (parse_options(options)?, parse_options(files)?);
    let given = read_input(mesh, file, importance)?;
    let outcome = run_in_background(py, threads, progress, move |channel| {
        embedded::simplify(options, &files, given, channel.listener(), &|| channel.check_cancelled())
    })?;
    Outcome::new(py, outcome)
}

/// Converts a mesh with the importance of its vertices, or else a file in memory.
pub fn read_input(
    mesh: Option<MeshArrays>,
    file: Option<(Vec<u8>, String)>,
    importance: Option<PyReadonlyArray1<f32>>,
) -> PyResult<Option<embedded::InputMesh>> {
    let factors = importance.map(|factors| Ok::<_, PyErr>(numbers(&factors, "importance")?.to_vec())).transpose()?;
    Ok(match (mesh, file) {
        (Some(mesh), _) => Some(embedded::InputMesh::Mesh(Box::new(mesh.read()?), factors)),
        (None, file) => file.map(|(bytes, name)| embedded::InputMesh::File(bytes, name)),
    })
}

impl Outcome {
    pub fn new(py: Python, outcome: embedded::Outcome) -> PyResult<Self> {
        let is_scene = outcome.file_vertices.is_none();
        let to_arrays = |result| Py::new(py, ResultArrays::new(py, result, is_scene)?);
        Ok(Self {
            results: outcome.results.into_iter().map(to_arrays).collect::<PyResult<_>>()?,
            report: values::to_python(py, &outcome.report)?,
            cleaned: outcome.cleaned,
            file_vertices: outcome.file_vertices.map(|vertices| indices(py, vertices)).transpose()?,
            group_names: outcome.group_names,
            paths: outcome.paths.iter().map(|path| path.to_string_lossy().into_owned()).collect(),
            bytes: outcome.bytes.map(|bytes| PyBytes::new(py, &bytes).unbind()),
            unmet: outcome.unmet,
        })
    }
}

impl ResultArrays {
    /// Converts a result; scenes have no arrays, since their meshes have different scales.
    fn new(py: Python, result: embedded::MemoryResult, is_scene: bool) -> PyResult<Self> {
        let embedded::MemoryResult { simplified, exact } = result;
        let (positions, faces) = if is_scene { Default::default() } else { simplified.mesh.into_parts() };
        let attributes = if is_scene { Attributes::default() } else { simplified.attributes };
        let vertices = match exact {
            Some(exact) => array(py, exact)?,
            None => array(py, positions)?,
        };
        let Attributes { wedges, channels, groups } = attributes;
        let channels = channels.into_iter().map(|channel| {
            let role = role_name(channel.role).to_string();
            Ok((channel.name, role, table(py, channel.values, channel.width)?))
        });
        Ok(Self {
            vertices,
            faces: triples(py, faces)?,
            wedges: (!wedges.is_empty()).then(|| triples(py, wedges)).transpose()?,
            channels: channels.collect::<PyResult<_>>()?,
            groups: (!groups.is_empty()).then(|| indices(py, groups)).transpose()?,
            sources: simplified.source_vertices.map(|sources| indices(py, sources)).transpose()?,
            map: simplified.map.map(|map| map_arrays(py, map)).transpose()?,
        })
    }
}

type MapArrays = (Py<PyAny>, Py<PyAny>, Py<PyAny>, Py<PyAny>);

fn map_arrays(py: Python, map: Map) -> PyResult<MapArrays> {
    let weights = array(py, map.corner_weights.into_flattened())?.call_method1(py, "reshape", (-1, 3, 3))?;
    Ok((indices(py, map.output_vertices)?, indices(py, map.input_vertices)?, triples(py, map.corner_faces)?, weights))
}
