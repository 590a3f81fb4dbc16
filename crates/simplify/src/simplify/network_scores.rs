//! Vertex scores from the network's Point Sampler, Sec. 3.1.

use std::borrow::Cow;
use std::sync::Arc;

use glam::Vec3;

use super::input::Input;
use super::options::{ClosedOptions, Purpose, ScoreSource};
use crate::geometry::triangle::area_normal;
use crate::linalg::Csr;
use crate::mesh::{TriMesh, vertex_normals};
use crate::model::{Weights, surface_scores};

/// Scores the vertices of a mesh; those with larger scores are sampled sooner.
///
/// ```
/// # use neural_mesh_simplify as neural_mesh;
/// use neural_mesh::{mesh::TriMesh, model::Weights, simplify::network_scores};
/// let mesh = TriMesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]).unwrap();
/// assert_eq!(network_scores(&mesh, &Weights::random(1)).len(), 3);
/// ```
pub fn network_scores(mesh: &TriMesh, weights: &Weights) -> Vec<f32> {
    let rings = Arc::new(edge_graph(mesh));
    surface_scores(weights, mesh.positions(), &vertex_normals(mesh), &rings)
}

/// Returns the scores of these weights for [`Input::scores`], if `source` is the network; else none.
pub fn asked_scores(source: ScoreSource, mesh: &TriMesh, weights: Option<&Weights>) -> Vec<f32> {
    match (source, weights) {
        (ScoreSource::Network, Some(weights)) => network_scores(mesh, weights),
        _ => Vec::new(),
    }
}

/// Returns the scores of the input, or else those of the network that ships, if the options name the network.
pub(super) fn used_scores<'a>(input: &Input<'a>, options: &ClosedOptions) -> Cow<'a, [f32]> {
    // The purpose Poses distributes the vertices by a term of its own, so only given scores count there.
    let is_asked = options.scores == ScoreSource::Network && options.purpose == Purpose::Shape;
    match input.scores.is_empty() && is_asked {
        true => network_scores(input.mesh, Weights::shipped_default()).into(),
        false => input.scores.into(),
    }
}

/// Sums a third of the area of each face at its vertices.
///
/// ```
/// # use neural_mesh_simplify as neural_mesh;
/// use neural_mesh::{mesh::TriMesh, simplify::vertex_areas};
/// let mesh = TriMesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 3.0, 0.0]], vec![[0, 1, 2]]).unwrap();
/// assert_eq!(vertex_areas(&mesh), [0.5; 3]);
/// ```
pub fn vertex_areas(mesh: &TriMesh) -> Vec<f64> {
    let mut areas = vec![0.0; mesh.positions().len()];
    for face in mesh.faces() {
        let normal = area_normal(face.map(|v| Vec3::from(mesh.positions()[v as usize])));
        face.iter().for_each(|&v| areas[v as usize] += f64::from(normal.length()) / 6.0);
    }
    areas
}

/// Builds the graph of a mesh's edges, n_vertices x n_vertices.
///
/// ```
/// # use neural_mesh_simplify as neural_mesh;
/// use neural_mesh::{mesh::shapes, simplify::edge_graph};
/// assert_eq!(edge_graph(&shapes::tetrahedron()).row(0), [1, 2, 3]);
/// ```
pub fn edge_graph(mesh: &TriMesh) -> Csr {
    let edges = mesh.faces().iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    Csr::from_edges(mesh.positions().len(), edges)
}
