//! Network of `neural_mesh::model` for other frameworks: weights as arrays, and stages with gradients.

use std::collections::HashMap;
use std::convert::Infallible;
use std::sync::{Arc, Mutex};

use neural_mesh::linalg::{Csr, Matrix};
use neural_mesh::model::{
    Architecture, Weights, edge_predictor_backward, edge_predictor_forward, face_classifier_backward,
    face_classifier_forward, point_sampler_backward, point_sampler_forward,
};
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::arrays::{indices_below, numbers, points, sequence, table};
use crate::background::{lock, run_in_background};
use crate::failure::invalid_array;
use crate::graphs::entries;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(shipped_weights, module)?)?;
    module.add_function(wrap_pyfunction!(random_weights, module)?)?;
    module.add_function(wrap_pyfunction!(read_weights, module)?)?;
    module.add_function(wrap_pyfunction!(weights_bytes, module)?)?;
    module.add_function(wrap_pyfunction!(point_sampler, module)?)?;
    module.add_function(wrap_pyfunction!(edge_predictor, module)?)?;
    module.add_function(wrap_pyfunction!(face_classifier, module)?)
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
    let of = |name: &str, smallest: usize| sizes.get(name).map_or(smallest.to_string(), i64::to_string);
    let words = SMALLEST_ARCHITECTURE.sizes().map(|(name, smallest)| format!("{name}={}", of(name, smallest)));
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

/// Function from gradients by a stage's outputs to gradients by its tensors and inputs, in order.
type Backward = Box<dyn Fn(&[Vec<f32>]) -> Vec<Matrix> + Send>;

/// Finished run of a network stage, with the backward pass.
#[pyclass(frozen, module = "neural_mesh._native")]
pub struct Pass {
    outputs: Vec<Vec<f32>>,
    backward: Arc<Mutex<Backward>>,
}

#[pymethods]
impl Pass {
    fn outputs(&self, py: Python) -> Vec<Py<PyAny>> {
        self.outputs.iter().map(|output| sequence(py, output.clone())).collect()
    }

    /// Returns a loss's gradients by tensors and inputs, in order, from those by the outputs.
    fn backward(
        &self,
        py: Python,
        gradients: Vec<PyReadonlyArray1<f32>>,
        threads: Option<usize>,
    ) -> PyResult<Vec<Py<PyAny>>> {
        let given = gradients.iter().map(|array| Ok(numbers(array, "gradient")?.to_vec()));
        let given = given.collect::<PyResult<Vec<_>>>()?;
        if !given.iter().map(Vec::len).eq(self.outputs.iter().map(Vec::len)) {
            return Err(invalid_array("gradient: give one of the size of each output"));
        }
        let backward = self.backward.clone();
        let results = run_in_background(py, threads, None, move |_| Ok(lock(&backward)(&given)))?;
        let of = |matrix: Matrix| {
            let n_columns = matrix.n_cols();
            table(py, matrix.into_data(), n_columns)
        };
        results.into_iter().map(of).collect()
    }
}

fn run_stage(
    py: Python,
    threads: Option<usize>,
    run: impl FnOnce() -> (Vec<Vec<f32>>, Backward) + Send + 'static,
) -> PyResult<Pass> {
    let (outputs, backward) = run_in_background(py, threads, None, move |_| Ok(run()))?;
    Ok(Pass { outputs, backward: Arc::new(Mutex::new(backward)) })
}

/// Runs the Point Sampler, Sec. 3.1: points n x 3, edges m x 2, normals n x 3.
#[pyfunction]
fn point_sampler(
    py: Python,
    given: WeightArrays,
    points: PyReadonlyArray2<f32>,
    edges: PyReadonlyArray2<i64>,
    normals: Option<PyReadonlyArray2<f32>>,
    threads: Option<usize>,
) -> PyResult<Pass> {
    let (weights, points) = (given.weights()?, self::points(&points, "points")?);
    let normals = normals.map(|normals| self::points(&normals, "normals")).transpose()?;
    if let Some(normals) = normals.as_ref().filter(|normals| normals.len() != points.len()) {
        return Err(invalid_array(format!("normals: {} rows for {} points", normals.len(), points.len())));
    }
    let edges = indices_below(&edges, points.len(), "edges")?;
    run_stage(py, threads, move || {
        let rings = Arc::new(Csr::from_edges(points.len(), edges));
        let pass = point_sampler_forward(&weights, &points, normals.as_deref(), &rings);
        let outputs = vec![pass.scores.clone()];
        let backward = move |given: &[Vec<f32>]| {
            let gradients = point_sampler_backward(&pass, &given[0]);
            let mut results = Vec::new();
            let Ok(_) = gradients.tensors.try_map("", &mut push_tensors(&mut results));
            results.push(Matrix::from_owned_points(gradients.points));
            results.extend(normals.is_some().then(|| Matrix::from_owned_points(gradients.normals)));
            results
        };
        (outputs, Box::new(backward))
    })
}

/// Runs the Edge Predictor, Sec. 3.2: points n x 3, edges m x 2, graph n_entries x 2. Returns S and A_s along the graph.
#[pyfunction]
fn edge_predictor(
    py: Python,
    given: WeightArrays,
    points: PyReadonlyArray2<f32>,
    edges: PyReadonlyArray2<i64>,
    graph: PyReadonlyArray2<i64>,
    threads: Option<usize>,
) -> PyResult<Pass> {
    let (weights, points) = (given.weights()?, self::points(&points, "points")?);
    let edges = indices_below(&edges, points.len(), "edges")?;
    let graph = entries(&graph, points.len(), "graph")?;
    if !graph.is_symmetric() {
        return Err(invalid_array("graph: an entry without its mirror image: give (j, i) for each (i, j)"));
    }
    run_stage(py, threads, move || {
        let original = Arc::new(Csr::from_edges(points.len(), edges));
        let pass = edge_predictor_forward(&weights, &points, &Arc::new(graph), &original);
        let outputs = vec![pass.attention.clone(), pass.adjacency.clone()];
        let backward = move |given: &[Vec<f32>]| {
            let gradients = edge_predictor_backward(&pass, &given[0], &given[1]);
            let mut results = Vec::new();
            let Ok(_) = gradients.tensors.try_map("", &mut push_tensors(&mut results));
            results.push(Matrix::from_owned_points(gradients.points));
            results
        };
        (outputs, Box::new(backward))
    })
}

/// Runs the Face Classifier, Sec. 3.3: points n x 3, prior n_faces, faces n_faces x 3, graph n_entries x 2.
#[pyfunction]
fn face_classifier(
    py: Python,
    given: WeightArrays,
    points: PyReadonlyArray2<f32>,
    prior: PyReadonlyArray1<f32>,
    faces: PyReadonlyArray2<i64>,
    graph: PyReadonlyArray2<i64>,
    threads: Option<usize>,
) -> PyResult<Pass> {
    let (weights, points) = (given.weights()?, self::points(&points, "points")?);
    let faces: Vec<[u32; 3]> = indices_below(&faces, points.len(), "faces")?;
    let prior = numbers(&prior, "prior")?.to_vec();
    if prior.len() != faces.len() || !prior.iter().all(|p| p.is_finite()) {
        return Err(invalid_array(format!("prior: give a finite number for each of {} faces", faces.len())));
    }
    let graph = Arc::new(entries(&graph, faces.len(), "graph")?);
    run_stage(py, threads, move || {
        let pass = face_classifier_forward(&weights, &points, &faces, &graph, &prior);
        let outputs = vec![pass.probabilities.clone()];
        let backward = move |given: &[Vec<f32>]| {
            let gradients = face_classifier_backward(&pass, &given[0]);
            let mut results = Vec::new();
            let Ok(_) = gradients.tensors.try_map("", &mut push_tensors(&mut results));
            results.push(Matrix::from_owned_points(gradients.points));
            results.push(Matrix::new(gradients.prior.len(), 1, gradients.prior));
            results
        };
        (outputs, Box::new(backward))
    })
}

fn push_tensors(results: &mut Vec<Matrix>) -> impl FnMut(&str, &Matrix) -> Result<(), Infallible> {
    |_, matrix| {
        results.push(matrix.clone());
        Ok(())
    }
}
