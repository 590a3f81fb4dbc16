//! Edges of a mesh with their faces.

use super::TriMesh;
use super::half_edges::for_each_edge;

/// An edge and its faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// Vertex indices, the smaller first.
    pub ends: [u32; 2],
    /// Number of faces that traverse the edge toward its larger vertex.
    pub up: u32,
    /// Number of faces that traverse the edge toward its smaller vertex.
    pub down: u32,
    /// Lowest face index at the edge.
    pub face: u32,
}

impl Edge {
    /// Returns the number of faces at the edge.
    pub fn n_faces(&self) -> u32 {
        self.up + self.down
    }
}

/// Lists the edges of a mesh, ascending.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::mesh::{edges, shapes};
/// let edges = edges(&shapes::icosphere(1));
/// assert!(edges.len() == 120 && edges.iter().all(|edge| (edge.up, edge.down) == (1, 1)));
/// ```
pub fn edges(mesh: &TriMesh) -> Vec<Edge> {
    let mut edges = Vec::with_capacity(3 * mesh.faces().len() / 2);
    for_each_edge(mesh.positions().len(), mesh.faces(), |ends, half_edges| {
        let up = half_edges.iter().filter(|half_edge| half_edge.runs_up(mesh.faces())).count() as u32;
        edges.push(Edge { ends, up, down: half_edges.len() as u32 - up, face: half_edges[0].face() });
    });
    edges
}
