//! Graphs and candidate faces of `neural_mesh::model` as rows of indices: what the stages of the network look along.

use neural_mesh::linalg::Csr;
use neural_mesh::mesh::{self, TriMesh};
use neural_mesh::model;
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::arrays::{array, indices_below, numbers, points};
use crate::failure::refused;
use crate::heard::heard;

/// Adds all this to the module.
pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(extended_graph, module)?)?;
    module.add_function(wrap_pyfunction!(triangle_graph, module)?)?;
    module.add_function(wrap_pyfunction!(candidate_faces, module)?)?;
    module.add_function(wrap_pyfunction!(vertex_normals, module)?)
}

/// The graph over `n` nodes that has these entries, in an order in which values can stand beside them.
pub fn entries(given: &PyReadonlyArray2<i64>, n: usize, what: &str) -> PyResult<Csr> {
    let given: Vec<[u32; 2]> = indices_below(given, n, what)?;
    if !given.is_sorted_by(|a, b| a < b) {
        return Err(refused(format!("{what}: give entries row by row, columns ascending, each once")));
    }
    Ok(Csr::from_entries(n, n, given.into_iter()))
}

/// The entries of G_ext, Sec. 3.2, with those of every point and itself: n_entries x 2.
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
    let entries = heard(py, threads, None, move |_| {
        let original = Csr::from_edges(points.len(), edges);
        Ok(model::extended_graph(&points, &original, knn).with_loops().entries().collect())
    })?;
    array::<u32, 2>(py, entries)
}

/// The entries of G_tri, Sec. 3.3: n_entries x 2.
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
    let entries =
        heard(py, threads, None, move |_| Ok(model::triangle_graph(&points, &faces, knn).entries().collect()))?;
    array::<u32, 2>(py, entries)
}

/// Candidate faces, Sec. 3.2, and where their edges stand among the entries of the graph: n_candidates x 3 each.
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
        return Err(refused(format!("adjacency: {} numbers for {} entries", adjacency.len(), graph.n_entries())));
    }
    let mut surface: Vec<[u32; 3]> = indices_below(&surface, points.len(), "surface")?;
    let found = heard(py, threads, None, move |_| {
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

/// Unit normals at the vertices of a mesh, n x 3; zero where there is none.
#[pyfunction]
fn vertex_normals(py: Python, vertices: PyReadonlyArray2<f32>, faces: PyReadonlyArray2<i64>) -> PyResult<Py<PyAny>> {
    let vertices = points(&vertices, "vertices")?;
    let faces = indices_below(&faces, vertices.len(), "faces")?;
    let mesh = TriMesh::new(vertices, faces).map_err(|error| refused(error.to_string()))?;
    array(py, py.detach(|| mesh::vertex_normals(&mesh)))
}
