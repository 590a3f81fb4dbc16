//! Edges without two consistently wound faces.

use super::{TriMesh, edges};

/// Irregular edges by kind, each as two vertices, the smaller first.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct IrregularEdges {
    /// Edges with one face.
    pub open: Vec<[u32; 2]>,
    /// Edges with three or more faces.
    pub non_manifold: Vec<[u32; 2]>,
    /// Edges with two faces that traverse them in the same direction.
    pub turned: Vec<[u32; 2]>,
}

/// Finds the irregular edges of a mesh.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::mesh::{irregular_edges, shapes};
/// let irregular = irregular_edges(&shapes::grid(3, 3));
/// assert!(irregular.open.len() == 12 && irregular.non_manifold.is_empty() && irregular.turned.is_empty());
/// ```
pub fn irregular_edges(mesh: &TriMesh) -> IrregularEdges {
    let mut irregular = IrregularEdges::default();
    for edge in edges(mesh) {
        match (edge.up, edge.down) {
            (1, 0) | (0, 1) => irregular.open.push(edge.ends),
            (1, 1) => {}
            (2, 0) | (0, 2) => irregular.turned.push(edge.ends),
            _ => irregular.non_manifold.push(edge.ends),
        }
    }
    irregular
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    fn mesh(faces: &[[u32; 3]]) -> TriMesh {
        TriMesh::new((0..6).map(|i| [i as f32, (i * i) as f32, 0.0]).collect(), faces.to_vec()).unwrap()
    }

    #[test]
    fn a_closed_surface_has_none() {
        assert_eq!(irregular_edges(&shapes::icosphere(2)), IrregularEdges::default());
    }

    #[test]
    fn every_kind_is_found() {
        assert_eq!(irregular_edges(&mesh(&[[0, 1, 2]])).open, [[0, 1], [0, 2], [1, 2]]);
        assert_eq!(irregular_edges(&mesh(&[[0, 1, 2], [0, 1, 3]])).turned, [[0, 1]]);
        assert_eq!(irregular_edges(&mesh(&[[0, 1, 2], [1, 0, 3]])).turned, [[0u32; 2]; 0]);
        assert_eq!(irregular_edges(&mesh(&[[0, 1, 2], [1, 0, 3], [0, 1, 4]])).non_manifold, [[0, 1]]);
    }
}
