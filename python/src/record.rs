//! `record`: a result as a function of the vertices given, with its gradient.

use neural_mesh::job::Arguments;
use neural_mesh::simplify::Record as Way;
use neural_mesh_cli::embedded::{self, Files};
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;

use crate::arrays::{array, indices, rows, triples};
use crate::failure::refused;
use crate::given::{Given, asked};
use crate::heard::heard;

/// How a result depends on the vertices given.
#[pyclass(frozen, module = "neural_mesh._native")]
pub struct Record {
    way: Way,
    origin: [f64; 3],
    /// The vertex given that each vertex of the function is.
    sources: Vec<u32>,
    n_given: usize,
    #[pyo3(get)]
    faces: Py<PyAny>,
}

/// Simplifies a mesh and records how the result depends on its vertices.
#[pyfunction]
#[pyo3(signature = (options, files, mesh, threads, progress))]
pub fn record(
    py: Python,
    options: &Bound<PyAny>,
    files: &Bound<PyAny>,
    mesh: Given,
    threads: Option<usize>,
    progress: Option<Bound<PyAny>>,
) -> PyResult<Record> {
    let (options, files): (Arguments, Files) = (asked(options)?, asked(files)?);
    let raw = mesh.read()?.mesh;
    let n_given = raw.positions.len();
    let recorded = heard(py, threads, progress, move |ear| embedded::record(options, &files, raw, ear.listener()))?;
    let embedded::Recorded { record: way, origin, sources, faces } = recorded;
    Ok(Record { way, origin, sources, n_given, faces: triples(py, faces)? })
}

#[pymethods]
impl Record {
    /// The vertices of the result (n_output x 3) for these given ones (n_given x 3).
    fn positions(&self, py: Python, vertices: PyReadonlyArray2<f64>) -> PyResult<Py<PyAny>> {
        let vertices = self.local(rows(&vertices, "vertices")?)?;
        let mut output = py.detach(|| self.way.positions_in_doubles(&vertices));
        output.iter_mut().for_each(|p| (0..3).for_each(|axis| p[axis] += self.origin[axis]));
        array(py, output)
    }

    /// The gradient to the vertices given (n_given x 3) from that to the vertices of the result (n_output x 3).
    fn backward(
        &self,
        py: Python,
        vertices: PyReadonlyArray2<f64>,
        gradient: PyReadonlyArray2<f64>,
    ) -> PyResult<Py<PyAny>> {
        let vertices = self.local(rows(&vertices, "vertices")?)?;
        let gradient = rows(&gradient, "gradient")?;
        if gradient.len() != self.n_output() {
            return Err(refused(format!("gradient: {} rows for {} vertices", gradient.len(), self.n_output())));
        }
        let to_local = py.detach(|| self.way.backward_in_doubles(&vertices, gradient));
        let mut to_given = vec![[0.0; 3]; self.n_given];
        self.sources.iter().zip(to_local).for_each(|(&v, to)| to_given[v as usize] = to);
        array(py, to_given)
    }

    /// For each vertex given the vertex of the result that it went to; -1 where it went nowhere, or was welded to another.
    fn output_vertices(&self, py: Python) -> PyResult<Py<PyAny>> {
        let mut outputs = vec![u32::MAX; self.n_given];
        let of_local = self.way.output_vertices();
        self.sources.iter().zip(of_local).for_each(|(&v, x)| outputs[v as usize] = x.unwrap_or(u32::MAX));
        indices(py, outputs)
    }

    /// Vertices given, and vertices of the result.
    fn sizes(&self) -> [usize; 2] {
        [self.n_given, self.n_output()]
    }
}

impl Record {
    fn n_output(&self) -> usize {
        self.way.n_output()
    }

    fn local(&self, given: &[[f64; 3]]) -> PyResult<Vec<[f64; 3]>> {
        if given.len() != self.n_given {
            return Err(refused(format!("vertices: {} rows for a record of {}", given.len(), self.n_given)));
        }
        let local = |&v: &u32| std::array::from_fn(|axis| given[v as usize][axis] - self.origin[axis]);
        Ok(self.sources.iter().map(local).collect())
    }
}
