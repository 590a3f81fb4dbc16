//! What a mesh is as a surface: closed or not, manifold or not, its pieces, holes and handles.

use super::TriMesh;
use super::half_edges::{HalfEdge, for_each_edge, next, start};
use super::sides::Sides;
use super::union_find::UnionFind;

/// The topology figures of a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Topology {
    /// Vertices of the mesh, used by a face or not.
    pub vertices: usize,
    /// Vertices that no face uses.
    pub unreferenced_vertices: usize,
    /// Edges.
    pub edges: usize,
    /// Faces.
    pub faces: usize,
    /// Whether there are faces and no edge has only one.
    pub closed: bool,
    /// Edges with one face.
    pub boundary_edges: usize,
    /// Closed curves that the boundary edges form.
    pub boundary_loops: usize,
    /// Edges with more than two faces.
    pub non_manifold_edges: usize,
    /// Vertices whose faces fall into several fans, where faces that share an edge at the vertex are in one fan.
    pub non_manifold_vertices: usize,
    /// Edges with two faces that both run along it in the same direction.
    pub inconsistent_edges: usize,
    /// Whether turning faces over can make the winding consistent across all edges with two faces.
    pub orientable: bool,
    /// Pieces of faces joined over edges.
    pub components: usize,
    /// Euler characteristic: vertices in use - edges + faces.
    pub euler: i64,
    /// Handles, summed over the components, boundaries filled in and vertices split where fans meet; only
    /// for orientable meshes without non-manifold edges.
    pub genus: Option<usize>,
}

impl Topology {
    /// Whether every edge has two faces that agree on the winding, and every vertex one fan.
    pub fn is_closed_manifold(&self) -> bool {
        self.closed && self.non_manifold_edges + self.non_manifold_vertices + self.inconsistent_edges == 0
    }
}

/// Counts the topology figures of a mesh, in time linear in its size.
///
/// ```
/// use neural_mesh::mesh::{TriMesh, topology};
/// let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let tetrahedron = TriMesh::new(corners, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]).unwrap();
/// let topology = topology(&tetrahedron);
/// assert!(topology.is_closed_manifold() && topology.genus == Some(0) && topology.euler == 2);
/// ```
pub fn topology(mesh: &TriMesh) -> Topology {
    let mut links = Links::new(mesh);
    for_each_edge(mesh.positions().len(), mesh.faces(), |_, half_edges| links.join(half_edges));
    links.summarise()
}

/// What is gathered edge by edge.
struct Links<'a> {
    mesh: &'a TriMesh,
    /// Sets of faces joined over edges.
    faces: UnionFind,
    /// Sets of corners (`3 * face + corner`) at one vertex joined over edges: the fans.
    corners: UnionFind,
    /// Pairs of faces over an edge, and whether they disagree on the winding.
    disagreeing: Vec<[u32; 2]>,
    boundary: Vec<u32>,
    edges: usize,
    non_manifold_edges: usize,
}

impl<'a> Links<'a> {
    fn new(mesh: &'a TriMesh) -> Self {
        let n_faces = mesh.faces().len();
        Self {
            mesh,
            faces: UnionFind::new(n_faces),
            corners: UnionFind::new(3 * n_faces),
            disagreeing: Vec::new(),
            boundary: Vec::new(),
            edges: 0,
            non_manifold_edges: 0,
        }
    }

    /// Takes in the half-edges of one edge.
    fn join(&mut self, half_edges: &[HalfEdge]) {
        self.edges += 1;
        match half_edges {
            [only] => self.boundary.push(only.half_edge),
            [_, _] => {}
            _ => self.non_manifold_edges += 1,
        }
        for pair in half_edges.windows(2) {
            let [x, y] = [pair[0].half_edge, pair[1].half_edge];
            self.faces.union(x / 3, y / 3);
            let agree = start(self.mesh.faces(), x) != start(self.mesh.faces(), y);
            let (at_start, at_end) = if agree { (next(y), y) } else { (y, next(y)) };
            self.corners.union(x, at_start);
            self.corners.union(next(x), at_end);
            if !agree && half_edges.len() == 2 {
                self.disagreeing.push([x / 3, y / 3]);
            }
        }
    }

    fn summarise(mut self) -> Topology {
        let n_vertices = self.mesh.positions().len();
        let n_faces = self.mesh.faces().len();
        let (unreferenced_vertices, non_manifold_vertices) = self.count_vertices();
        let used = n_vertices - unreferenced_vertices;
        let boundary_loops = self.count_loops();
        let orientable = self.disagreeing.is_empty() || is_orientable(self.mesh);
        let holes_filled = self.corners.sets() + n_faces + boundary_loops;
        let handles = (2 * self.faces.sets() + self.edges).checked_sub(holes_filled).map(|twice| twice / 2);
        Topology {
            vertices: n_vertices,
            unreferenced_vertices,
            edges: self.edges,
            faces: n_faces,
            closed: n_faces > 0 && self.boundary.is_empty(),
            boundary_edges: self.boundary.len(),
            boundary_loops,
            non_manifold_edges: self.non_manifold_edges,
            non_manifold_vertices,
            inconsistent_edges: self.disagreeing.len(),
            orientable,
            components: self.faces.sets(),
            euler: used as i64 - self.edges as i64 + n_faces as i64,
            genus: handles.filter(|_| orientable && self.non_manifold_edges == 0),
        }
    }

    /// Vertices that no face uses, and vertices with several fans.
    fn count_vertices(&mut self) -> (usize, usize) {
        let mut fans = vec![0u32; self.mesh.positions().len()];
        for corner in 0..3 * self.mesh.faces().len() as u32 {
            if self.corners.find(corner) == corner {
                fans[start(self.mesh.faces(), corner) as usize] += 1;
            }
        }
        let count = |wanted: fn(u32) -> bool| fans.iter().filter(|&&n| wanted(n)).count();
        (count(|n| n == 0), count(|n| n > 1))
    }

    /// Pieces of the boundary, where it passes through a vertex once per fan.
    fn count_loops(&mut self) -> usize {
        let mut ends: Vec<[u32; 2]> = Vec::with_capacity(self.boundary.len());
        for &half_edge in &self.boundary {
            ends.push([self.corners.find(half_edge), self.corners.find(next(half_edge))]);
        }
        let mut fans: Vec<u32> = ends.iter().flatten().copied().collect();
        fans.sort_unstable();
        fans.dedup();
        let mut loops = UnionFind::new(fans.len());
        let place = |fan: u32| fans.partition_point(|&other| other < fan) as u32;
        for [a, b] in ends {
            loops.union(place(a), place(b));
        }
        loops.sets()
    }
}

/// Whether the faces can be turned so that all agree over the edges with two.
fn is_orientable(mesh: &TriMesh) -> bool {
    let mut sides = Sides::new(mesh.faces().len());
    let mut all_agree = true;
    for_each_edge(mesh.positions().len(), mesh.faces(), |_, half_edges| {
        if let &[g, h] = half_edges {
            all_agree &= sides.join([g.face(), h.face()], g.runs_up(mesh.faces()) == h.runs_up(mesh.faces()));
        }
    });
    all_agree
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rand_xoshiro::rand_core::{Rng, SeedableRng};
    use std::collections::{BTreeMap, BTreeSet};

    fn mesh(n_vertices: usize, faces: &[[u32; 3]]) -> TriMesh {
        TriMesh::new(vec![[0.0; 3]; n_vertices], faces.to_vec()).unwrap()
    }

    /// Faces over each edge, with whether they run from the smaller to the larger vertex.
    fn naive_edges(faces: &[[u32; 3]]) -> BTreeMap<(u32, u32), Vec<(usize, bool)>> {
        let mut edges: BTreeMap<_, Vec<_>> = BTreeMap::new();
        for (i, &[a, b, c]) in faces.iter().enumerate() {
            for (a, b) in [(a, b), (b, c), (c, a)] {
                edges.entry((a.min(b), a.max(b))).or_default().push((i, a < b));
            }
        }
        edges
    }

    /// Number of pieces of a graph over some nodes, by flooding.
    fn naive_pieces<T: Copy + Ord>(nodes: &BTreeSet<T>, linked: impl Fn(T, T) -> bool) -> usize {
        let mut left = nodes.clone();
        let mut pieces = 0;
        while let Some(first) = left.pop_first() {
            pieces += 1;
            let mut front = vec![first];
            while let Some(x) = front.pop() {
                let near: Vec<T> = left.iter().copied().filter(|&y| linked(x, y)).collect();
                near.iter().for_each(|y| assert!(left.remove(y)));
                front.extend(near);
            }
        }
        pieces
    }

    fn naive_fans(faces: &[[u32; 3]], vertex: u32) -> usize {
        let around = (0..faces.len()).filter(|&f| faces[f].contains(&vertex)).collect();
        naive_pieces(&around, |f, g| faces[f].iter().any(|v| *v != vertex && faces[g].contains(v)))
    }

    #[test]
    fn agrees_with_naive_counts_on_random_soups() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(4);
        for round in 0..60 {
            let n = 5 + round % 9;
            let mut vertex = || rng.next_u32() % n;
            let faces: Vec<[u32; 3]> = (0..2 + round).map(|_| [vertex(), vertex(), vertex()]).collect();
            let faces: Vec<_> = faces.into_iter().filter(|&[a, b, c]| a != b && b != c && c != a).collect();
            let found = topology(&mesh(n as usize, &faces));
            let edges = naive_edges(&faces);
            let with = |n_faces: std::ops::Range<usize>| edges.values().filter(|e| n_faces.contains(&e.len())).count();
            let same_way = |e: &&Vec<(usize, bool)>| e.len() == 2 && e[0].1 == e[1].1;
            assert_eq!(found.edges, edges.len());
            assert_eq!(found.boundary_edges, with(1..2));
            assert_eq!(found.non_manifold_edges, with(3..usize::MAX));
            assert_eq!(found.inconsistent_edges, edges.values().filter(same_way).count());
            let fans: Vec<usize> = (0..n).map(|v| naive_fans(&faces, v)).collect();
            assert_eq!(found.non_manifold_vertices, fans.iter().filter(|&&f| f > 1).count());
            assert_eq!(found.unreferenced_vertices, fans.iter().filter(|&&f| f == 0).count());
            let share_edge = |f: usize, g: usize| faces[f].iter().filter(|v| faces[g].contains(v)).count() > 1;
            assert_eq!(found.components, naive_pieces(&(0..faces.len()).collect(), share_edge));
        }
    }

    #[test]
    fn a_face_turned_over_is_inconsistent_and_still_orientable() {
        let sphere = shapes::icosphere(1);
        let mut faces = sphere.faces().to_vec();
        faces[7].swap(0, 1);
        let topology = topology(&TriMesh::new(sphere.positions().to_vec(), faces).unwrap());
        assert_eq!((topology.inconsistent_edges, topology.orientable, topology.genus), (3, true, Some(0)));
        assert!(!topology.is_closed_manifold());
    }

    #[test]
    fn holes_that_meet_in_a_vertex_are_two_loops() {
        // A ring of six faces around vertex 0 without two opposite ones: the boundary passes 0 twice.
        let fan = mesh(7, &[[0, 1, 2], [0, 2, 3], [0, 4, 5], [0, 5, 6]]);
        let topology = topology(&fan);
        assert_eq!((topology.non_manifold_vertices, topology.boundary_loops, topology.components), (1, 2, 2));
        assert_eq!(topology.genus, Some(0));
    }

    #[test]
    fn nothing_has_no_topology() {
        assert_eq!(topology(&TriMesh::default()), Topology { orientable: true, genus: Some(0), ..Topology::default() });
    }
}
