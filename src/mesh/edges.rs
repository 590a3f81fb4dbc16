//! The edges of a mesh, each once, with the faces that run along it.

use super::TriMesh;

/// An edge and its faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// Its vertices, the smaller first.
    pub ends: [u32; 2],
    /// Faces that run along it from the smaller vertex to the larger.
    pub up: u32,
    /// Faces that run along it the other way.
    pub down: u32,
    /// The first of all these faces.
    pub face: u32,
}

impl Edge {
    /// Faces at the edge: one at a border, two inside of a manifold.
    pub fn n_faces(&self) -> u32 {
        self.up + self.down
    }
}

/// The edges of a mesh, ascending by their vertices, in time linear in its size.
///
/// ```
/// use neural_mesh::mesh::{edges, shapes};
/// let edges = edges(&shapes::icosphere(1));
/// assert!(edges.len() == 120 && edges.iter().all(|edge| (edge.up, edge.down) == (1, 1)));
/// ```
pub fn edges(mesh: &TriMesh) -> Vec<Edge> {
    let mut edges = Vec::with_capacity(3 * mesh.faces().len() / 2);
    for_each_edge(mesh, |half_edges| {
        let start = |half_edge: u32| mesh.faces()[half_edge as usize / 3][half_edge as usize % 3];
        let (first, end) = (half_edges[0].half_edge, half_edges[0].end);
        let up = half_edges.iter().filter(|half_edge| start(half_edge.half_edge) != end).count() as u32;
        let low = if start(first) == end { start(next_corner(first)) } else { start(first) };
        edges.push(Edge { ends: [low, end], up, down: half_edges.len() as u32 - up, face: first / 3 });
    });
    edges
}

/// Half-edge `3 * face + corner` runs from that corner to the next; `end` is its vertex with the larger index.
#[derive(Clone, Copy, Default)]
pub(super) struct HalfEdge {
    pub end: u32,
    pub half_edge: u32,
}

/// Calls `visit` with the half-edges of every edge, edges ascending by their ends, half-edges by their number.
pub(super) fn for_each_edge(mesh: &TriMesh, mut visit: impl FnMut(&[HalfEdge])) {
    let (starts, mut half_edges) = half_edges_by_smaller_vertex(mesh);
    for range in starts.windows(2) {
        let bucket = &mut half_edges[range[0] as usize..range[1] as usize];
        bucket.sort_unstable_by_key(|h| (h.end, h.half_edge));
        bucket.chunk_by(|x, y| x.end == y.end).for_each(&mut visit);
    }
}

/// All half-edges, those of vertex `v` (the smaller of the two) at `starts[v]..starts[v + 1]`.
fn half_edges_by_smaller_vertex(mesh: &TriMesh) -> (Vec<u32>, Vec<HalfEdge>) {
    let mut starts = vec![0u32; mesh.positions().len() + 2];
    for [a, b] in ends_of_half_edges(mesh) {
        starts[a.min(b) as usize + 2] += 1;
    }
    for v in 2..starts.len() {
        starts[v] += starts[v - 1];
    }
    let mut half_edges = vec![HalfEdge::default(); 3 * mesh.faces().len()];
    for ([a, b], half_edge) in ends_of_half_edges(mesh).zip(0..) {
        let slot = &mut starts[a.min(b) as usize + 1];
        half_edges[*slot as usize] = HalfEdge { end: a.max(b), half_edge };
        *slot += 1;
    }
    starts.pop();
    (starts, half_edges)
}

fn ends_of_half_edges(mesh: &TriMesh) -> impl Iterator<Item = [u32; 2]> {
    mesh.faces().iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
}

/// Corner of the vertex where the half-edge ends: the next one of the same face.
pub(super) fn next_corner(half_edge: u32) -> u32 {
    if half_edge % 3 == 2 { half_edge - 2 } else { half_edge + 1 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rand_xoshiro::rand_core::{Rng, SeedableRng};
    use std::collections::BTreeMap;

    /// The same by a map from ends to counts.
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
