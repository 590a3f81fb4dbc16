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

#[cfg(test)]
mod tests {
    use super::*;
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rand_xoshiro::rand_core::{Rng, SeedableRng};
    use std::collections::BTreeMap;

    fn naive(mesh: &TriMesh) -> Vec<Edge> {
        let mut found: BTreeMap<[u32; 2], Edge> = BTreeMap::new();
        for (face, &[a, b, c]) in (0..).zip(mesh.faces()) {
            for [a, b] in [[a, b], [b, c], [c, a]] {
                let ends = [a.min(b), a.max(b)];
                let edge = found.entry(ends).or_insert(Edge { ends, up: 0, down: 0, face });
                *(if a < b { &mut edge.up } else { &mut edge.down }) += 1;
            }
        }
        found.into_values().collect()
    }

    #[test]
    fn agree_with_a_map_on_random_soups() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
        for round in 0..40 {
            let n = 4 + round % 9;
            let mut vertex = || rng.next_u32() % n;
            let faces: Vec<[u32; 3]> = (0..3 * round).map(|_| [vertex(), vertex(), vertex()]).collect();
            let faces = faces.into_iter().filter(|&[a, b, c]| a != b && b != c && c != a).collect();
            let mesh = TriMesh::new(vec![[0.0; 3]; n as usize], faces).unwrap();
            assert_eq!(edges(&mesh), naive(&mesh));
        }
    }
}
