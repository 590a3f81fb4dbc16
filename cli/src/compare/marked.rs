//! Edges that the page marks: those that are not shared by two faces that agree on the side they look to.

use neural_mesh::mesh::TriMesh;
use rayon::prelude::*;

/// Irregular edges by kind, each as its two vertices, the smaller first.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Marked {
    /// Edges with one face.
    pub open: Vec<[u32; 2]>,
    /// Edges with three or more faces.
    pub non_manifold: Vec<[u32; 2]>,
    /// Edges with two faces that both run along it in the same direction.
    pub turned: Vec<[u32; 2]>,
}

/// Finds the irregular edges of a mesh.
pub fn marked(mesh: &TriMesh) -> Marked {
    let sides = mesh.faces().iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let mut sides: Vec<([u32; 2], bool)> = sides.map(|[a, b]| ([a.min(b), a.max(b)], a < b)).collect();
    sides.par_sort_unstable();
    let mut marked = Marked::default();
    for edge in sides.chunk_by(|a, b| a.0 == b.0) {
        match edge {
            [_] => marked.open.push(edge[0].0),
            [first, second] if first.1 == second.1 => marked.turned.push(edge[0].0),
            [_, _] => {}
            _ => marked.non_manifold.push(edge[0].0),
        }
    }
    marked
}

#[cfg(test)]
mod tests {
    use super::*;
    use neural_mesh::mesh::shapes;

    fn mesh(faces: &[[u32; 3]]) -> TriMesh {
        TriMesh::new((0..6).map(|i| [i as f32, (i * i) as f32, 0.0]).collect(), faces.to_vec()).unwrap()
    }

    #[test]
    fn a_closed_surface_has_none() {
        assert_eq!(marked(&shapes::icosphere(2)), Marked::default());
    }

    #[test]
    fn every_kind_is_found() {
        assert_eq!(marked(&mesh(&[[0, 1, 2]])).open, [[0, 1], [0, 2], [1, 2]]);
        assert_eq!(marked(&mesh(&[[0, 1, 2], [0, 1, 3]])).turned, [[0, 1]]);
        assert_eq!(marked(&mesh(&[[0, 1, 2], [1, 0, 3]])).turned, [[0u32; 2]; 0]);
        assert_eq!(marked(&mesh(&[[0, 1, 2], [1, 0, 3], [0, 1, 4]])).non_manifold, [[0, 1]]);
    }
}
