//! Graphs and candidate faces of `neural_mesh::model` as rows of indices.

use neural_mesh::linalg::Csr;
use neural_mesh::mesh::{self, TriMesh};
use neural_mesh::model;
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::arrays::{array, indices_below, numbers, points};
use crate::background::run_in_background;
use crate::failure::invalid_array;

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(extended_graph, module)?)?;
    module.add_function(wrap_pyfunction!(triangle_graph, module)?)?;
    module.add_function(wrap_pyfunction!(candidate_faces, module)?)?;
    module.add_function(wrap_pyfunction!(vertex_normals, module)?)
}

/// Returns the graph over `n` nodes with these entries (i, j), given in order.
pub fn entries(given: &PyReadonlyArray2<i64>, n: usize, what: &str) -> PyResult<Csr> {
    let given: Vec<[u32; 2]> = indices_below(given, n, what)?;
    if !given.is_sorted_by(|a, b| a < b) {
        return Err(invalid_array(format!("{what}: give entries row by row, columns ascending, each once")));
    }
    Ok(Csr::from_entries(n, n, given.into_iter()))
}

/// Returns the entries of G_ext, Sec. 3.2, with loops: n_entries x 2.
#[pyfunction]
fn extended_graph(
    py: Python,
    points: PyReadonlyArray2<f32>,
    edges: PyReadonlyArray2<i64>,
    knn: usize,
    threads: Option<usize>,
) -> PyResult<Py<PyAny>> {
    let points = self::points(&points, "points")?;
    let edges = indices_below(&edges, points.len(), "edges")?;
    let entries = run_in_background(py, threads, None, move |_| {
        let original = Csr::from_edges(points.len(), edges);
        Ok(model::extended_graph(&points, &original, knn).with_loops().entries().collect())
    })?;
    array::<u32, 2>(py, entries)
}

/// Returns the entries of G_tri, Sec. 3.3: n_entries x 2.
#[pyfunction]
fn triangle_graph(
    py: Python,
    points: PyReadonlyArray2<f32>,
    faces: PyReadonlyArray2<i64>,
    knn: usize,
    threads: Option<usize>,
) -> PyResult<Py<PyAny>> {
    let points = self::points(&points, "points")?;
    let faces: Vec<[u32; 3]> = indices_below(&faces, points.len(), "faces")?;
    let entries = run_in_background(py, threads, None, move |_| {
        Ok(model::triangle_graph(&points, &faces, knn).entries().collect())
    })?;
    array::<u32, 2>(py, entries)
}

/// Returns candidate faces, Sec. 3.2, and their edges' indices among the graph's entries: n_candidates x 3 each.
#[pyfunction]
fn candidate_faces(
    py: Python,
    points: PyReadonlyArray2<f32>,
    graph: PyReadonlyArray2<i64>,
    adjacency: PyReadonlyArray1<f32>,
    surface: PyReadonlyArray2<i64>,
    per_point: usize,
    threads: Option<usize>,
) -> PyResult<(Py<PyAny>, Py<PyAny>)> {
    let points = self::points(&points, "points")?;
    let graph = entries(&graph, points.len(), "graph")?;
    let adjacency = numbers(&adjacency, "adjacency")?.to_vec();
    if adjacency.len() != graph.n_entries() {
        return Err(invalid_array(format!("adjacency: {} numbers for {} entries", adjacency.len(), graph.n_entries())));
    }
    let mut surface: Vec<[u32; 3]> = indices_below(&surface, points.len(), "surface")?;
    let found = run_in_background(py, threads, None, move |_| {
        surface.iter_mut().for_each(|face| face.sort_unstable());
        surface.sort_unstable();
        let mut candidates = model::candidate_faces(&graph, &adjacency, &surface);
        if per_point > 0 {
            candidates = candidates.with_largest_prior(per_point.saturating_mul(points.len()), &adjacency, &surface);
        }
        Ok(candidates.in_coherent_order(&points))
    })?;
    Ok((array(py, found.triangles)?, array(py, found.entries.to_vec())?))
}

/// Returns unit normals at the vertices of a mesh, n x 3; zero where undefined.
#[pyfunction]
fn vertex_normals(py: Python, vertices: PyReadonlyArray2<f32>, faces: PyReadonlyArray2<i64>) -> PyResult<Py<PyAny>> {
    let vertices = points(&vertices, "vertices")?;
    let faces = indices_below(&faces, vertices.len(), "faces")?;
    let mesh = TriMesh::new(vertices, faces).map_err(|error| invalid_array(error.to_string()))?;
    array(py, py.detach(|| mesh::vertex_normals(&mesh)))
}
