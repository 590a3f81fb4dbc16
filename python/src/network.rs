//! Weights of `neural_mesh::model` as arrays, and the library's own results of the paper's stages.

use std::collections::HashMap;
use std::sync::Arc;

use neural_mesh::linalg::Matrix;
use neural_mesh::mesh::TriMesh;
use neural_mesh::model::{Architecture, Weights};
use neural_mesh::simplify::PaperOptions;
use neural_mesh::simplify::paper::{PaperStages, choose_faces, orient_triangle, paper_stages as run_stages};
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::arrays::{array, indices, indices_below, points, sequence, table, triples};
use crate::background::run_in_background;
use crate::failure::invalid_array;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(shipped_weights, module)?)?;
    module.add_function(wrap_pyfunction!(random_weights, module)?)?;
    module.add_function(wrap_pyfunction!(read_weights, module)?)?;
    module.add_function(wrap_pyfunction!(weights_bytes, module)?)?;
    module.add_function(wrap_pyfunction!(paper_stages, module)?)
}

/// Sizes by their names in [`Architecture`].
type Sizes = HashMap<String, i64>;

/// Sizes, named tensors, and the objective if known.
type WeightParts = (Vec<(&'static str, usize)>, Vec<(String, Py<PyAny>)>, Option<String>);

#[derive(FromPyObject)]
struct WeightArrays<'py>(Sizes, Vec<(String, PyReadonlyArray2<'py, f32>)>);

#[pyfunction]
fn shipped_weights(py: Python, name: &str) -> PyResult<WeightParts> {
    match name {
        "default" => weight_parts(py, Weights::shipped_default()),
        "paper-open" => weight_parts(py, Weights::shipped_paper_open()),
        _ => {
            Err(invalid_array(format!("no weights \"{name}\" ship: give \"default\" or \"paper-open\", or from_file")))
        }
    }
}

/// Returns random initial weights.
#[pyfunction]
fn random_weights(py: Python, sizes: Sizes, seed: u64) -> PyResult<WeightParts> {
    weight_parts(py, &Weights::random_of(architecture(&sizes)?, seed))
}

/// Reads weights from the bytes of a safetensors file.
#[pyfunction]
fn read_weights(py: Python, bytes: &[u8]) -> PyResult<WeightParts> {
    weight_parts(py, &Weights::from_bytes(bytes).map_err(|error| invalid_array(error.to_string()))?)
}

#[pyfunction]
fn weights_bytes(py: Python, given: WeightArrays, objective: Option<&str>) -> PyResult<Py<PyBytes>> {
    let weights = given.weights()?;
    let weights = objective.into_iter().fold(weights, |weights, objective| weights.with_objective(objective));
    Ok(PyBytes::new(py, &weights.to_bytes()).unbind())
}

fn weight_parts(py: Python, weights: &Weights) -> PyResult<WeightParts> {
    let mut tensors = Vec::new();
    weights.tensors().try_map(|name, matrix| {
        tensors.push((name.to_string(), table(py, matrix.data().to_vec(), matrix.n_cols())?));
        Ok::<_, PyErr>(())
    })?;
    Ok((weights.architecture().sizes().to_vec(), tensors, weights.objective().map(String::from)))
}

/// Sizes of stages for which the caller gives none.
const SMALLEST_ARCHITECTURE: Architecture = Architecture {
    point_sampler_inputs: 3,
    point_sampler_layers: 1,
    point_sampler_width: 1,
    point_sampler_hidden: 0,
    edge_predictor_width: 1,
    attention_width: 1,
    edge_knn: 1,
    face_classifier_layers: 1,
    face_classifier_width: 1,
    face_candidates: 0,
    face_knn: 1,
};

fn architecture(sizes: &Sizes) -> PyResult<Architecture> {
    let describe_size = |name: &str, smallest: usize| sizes.get(name).map_or(smallest.to_string(), i64::to_string);
    let words =
        SMALLEST_ARCHITECTURE.sizes().map(|(name, smallest)| format!("{name}={}", describe_size(name, smallest)));
    Architecture::from_text(&words.join(" ")).map_err(|why| invalid_array(format!("the sizes of the network: {why}")))
}

impl WeightArrays<'_> {
    /// Returns the weights; tensors of missing stages are zero.
    fn weights(&self) -> PyResult<Weights> {
        let Self(sizes, tensors) = self;
        let tensors: HashMap<&str, &PyReadonlyArray2<f32>> =
            tensors.iter().map(|(name, array)| (name.as_str(), array)).collect();
        let architecture = architecture(sizes)?;
        let tensors = architecture.shapes().try_map(|name, &[n_rows, n_cols]| match tensors.get(name) {
            Some(array) => matrix(array, name),
            None => Ok(Arc::new(Matrix::zeros(n_rows, n_cols))),
        })?;
        Weights::from_tensors(architecture, tensors).map_err(|error| invalid_array(error.to_string()))
    }
}

fn matrix(array: &PyReadonlyArray2<f32>, what: &str) -> PyResult<Arc<Matrix>> {
    let (n_rows, n_cols) = array.as_array().dim();
    let numbers = array.as_slice().map_err(|_| invalid_array(format!("{what}: the array is not contiguous")))?;
    Ok(Arc::new(Matrix::new(n_rows, n_cols, numbers.to_vec())))
}

/// Runs the stages of the paper's assembly in the library: what `neural_mesh.torch` is compared with.
///
/// Points n x 3, faces m x 3; returns arrays by name.
#[pyfunction]
fn paper_stages(
    py: Python,
    vertices: PyReadonlyArray2<f32>,
    faces: PyReadonlyArray2<i64>,
    n_samples: usize,
    weights: &[u8],
    seed: u64,
    threads: Option<usize>,
) -> PyResult<Py<PyDict>> {
    let weights = Weights::from_bytes(weights).map_err(|error| invalid_array(error.to_string()))?;
    let positions = points(&vertices, "vertices")?;
    let faces: Vec<[u32; 3]> = indices_below(&faces, positions.len(), "faces")?;
    let mesh = TriMesh::new(positions, faces).map_err(|error| invalid_array(error.to_string()))?;
    let options = PaperOptions { weights: Some(weights.into()), seed, ..PaperOptions::default() };
    let (stages, faces) = run_in_background(py, threads, None, move |channel| {
        let stages = run_stages(&mesh, n_samples, &options, &mut *channel.listener())?;
        let faces = assemble_faces(&stages, mesh.positions());
        Ok((stages, faces))
    })?;
    let PaperStages { scores, samples, assignment, quotient, edges, faces: judged } = stages;
    let arrays = PyDict::new(py);
    arrays.set_item("scores", sequence(py, scores))?;
    arrays.set_item("samples", indices(py, samples)?)?;
    arrays.set_item("assignment", indices(py, assignment)?)?;
    arrays.set_item("surface", triples(py, quotient.triangles)?)?;
    arrays.set_item("graph", array(py, edges.graph.entries().collect::<Vec<[u32; 2]>>())?)?;
    arrays.set_item("attention", sequence(py, edges.attention))?;
    arrays.set_item("adjacency", sequence(py, edges.adjacency))?;
    arrays.set_item("candidates", triples(py, judged.candidates.triangles)?)?;
    arrays.set_item("prior", sequence(py, judged.prior))?;
    arrays.set_item("probabilities", sequence(py, judged.probabilities))?;
    arrays.set_item("faces", triples(py, faces)?)?;
    Ok(arrays.unbind())
}

/// Assembles the faces of the result over the vertices of the input.
fn assemble_faces(stages: &PaperStages, positions: &[[f32; 3]]) -> Vec<[u32; 3]> {
    let sampled: Vec<[f32; 3]> = stages.samples.iter().map(|&vertex| positions[vertex as usize]).collect();
    let chosen = choose_faces(&stages.faces, stages.edges.graph.n_entries());
    let triangles = chosen.iter().map(|&at| stages.faces.candidates.triangles[at]);
    let wound = triangles.map(|triangle| orient_triangle(triangle, &sampled, &stages.quotient));
    wound.map(|face| face.map(|sample| stages.samples[sample as usize])).collect()
}
