//! `record`: a result as a differentiable function of the input vertices.

use neural_mesh::job::Arguments;
use neural_mesh::simplify::Record as LibraryRecord;
use neural_mesh_cli::embedded::{self, Files};
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;

use crate::arrays::{array, indices, rows, triples};
use crate::background::run_in_background;
use crate::failure::invalid_array;
use crate::mesh_arrays::{MeshArrays, parse_options};

/// Result as a function of the input vertices.
#[pyclass(frozen, module = "neural_mesh._native")]
pub struct Record {
    record: LibraryRecord,
    origin: [f64; 3],
    /// Input vertex of each vertex of the function.
    sources: Vec<u32>,
    n_given: usize,
    #[pyo3(get)]
    faces: Py<PyAny>,
}

/// Simplifies a mesh and records the result as a function of its vertices.
#[pyfunction]
#[pyo3(signature = (options, files, mesh, threads, progress))]
pub fn record(
    py: Python,
    options: &Bound<PyAny>,
    files: &Bound<PyAny>,
    mesh: MeshArrays,
    threads: Option<usize>,
    progress: Option<Bound<PyAny>>,
) -> PyResult<Record> {
    let (options, files): (Arguments, Files) = (parse_options(options)?, parse_options(files)?);
    let raw = mesh.read()?.mesh;
    let n_given = raw.positions.len();
    let recorded = run_in_background(py, threads, progress, move |channel| {
        embedded::record(options, &files, raw, channel.listener())
    })?;
    let embedded::RecordedResult { record, origin, sources, faces } = recorded;
    Ok(Record { record, origin, sources, n_given, faces: triples(py, faces)? })
}

#[pymethods]
impl Record {
    /// Evaluates the result's vertices (n_output x 3) for input vertices (n_given x 3).
    fn positions(&self, py: Python, vertices: PyReadonlyArray2<f64>) -> PyResult<Py<PyAny>> {
        let vertices = self.local(rows(&vertices, "vertices")?)?;
        let mut output = py.detach(|| self.record.positions_in_doubles(&vertices));
        output.iter_mut().for_each(|p| (0..3).for_each(|axis| p[axis] += self.origin[axis]));
        array(py, output)
    }

    /// Returns a loss's gradient by the input vertices (n_given x 3) from that by the result's vertices (n_output x 3).
    fn backward(
        &self,
        py: Python,
        vertices: PyReadonlyArray2<f64>,
        gradient: PyReadonlyArray2<f64>,
    ) -> PyResult<Py<PyAny>> {
        let vertices = self.local(rows(&vertices, "vertices")?)?;
        let gradient = rows(&gradient, "gradient")?;
        if gradient.len() != self.n_output() {
            return Err(invalid_array(format!("gradient: {} rows for {} vertices", gradient.len(), self.n_output())));
        }
        let to_local = py.detach(|| self.record.backward_in_doubles(&vertices, gradient));
        let mut to_input = vec![[0.0; 3]; self.n_given];
        self.sources.iter().zip(to_local).for_each(|(&v, to)| to_input[v as usize] = to);
        array(py, to_input)
    }

    /// Returns the output vertex of each input vertex; -1 if it was removed or welded to another.
    fn output_vertices(&self, py: Python) -> PyResult<Py<PyAny>> {
        let mut outputs = vec![u32::MAX; self.n_given];
        let of_local = self.record.output_vertices();
        self.sources.iter().zip(of_local).for_each(|(&v, x)| outputs[v as usize] = x.unwrap_or(u32::MAX));
        indices(py, outputs)
    }

    /// Returns the numbers of input and output vertices.
    fn sizes(&self) -> [usize; 2] {
        [self.n_given, self.n_output()]
    }
}

impl Record {
    fn n_output(&self) -> usize {
        self.record.n_output()
    }

    fn local(&self, given: &[[f64; 3]]) -> PyResult<Vec<[f64; 3]>> {
        if given.len() != self.n_given {
            return Err(invalid_array(format!("vertices: {} rows for a record of {}", given.len(), self.n_given)));
        }
        let local = |&v: &u32| std::array::from_fn(|axis| given[v as usize][axis] - self.origin[axis]);
        Ok(self.sources.iter().map(local).collect())
    }
}
