//! Topology of a mesh.

use super::TriMesh;
use super::first_equal::PositionKey;
use super::topology_figures::Topology;
use super::topology_patch::{OpenEdge, TopologyPatch, curves_through};
use super::union_find::UnionFind;
use super::windings::Windings;

/// Counts the topology figures of a mesh in linear time.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::mesh::{TriMesh, topology};
/// let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let tetrahedron = TriMesh::new(corners, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]).unwrap();
/// let topology = topology(&tetrahedron);
/// assert!(topology.is_closed_manifold() && topology.genus == Some(0) && topology.euler == 2);
/// ```
pub fn topology(mesh: &TriMesh) -> Topology {
    let mut patches = TopologyPatches::default();
    patches.add(TopologyPatch::new(mesh, |_| false));
    patches.count_topology()
}

#[derive(Debug, Default)]
#[doc(hidden)]
pub struct TopologyPatches(TopologyPatch);

impl TopologyPatches {
    pub fn add(&mut self, patch: TopologyPatch) {
        let all = &mut self.0;
        let (fans, components, sides) = (all.open_fans.len() as u32, all.n_open_components, all.n_open_sides);
        all.closed.add(&patch.closed);
        all.n_closed_fans += patch.n_closed_fans;
        all.is_one_sided |= patch.is_one_sided;
        all.n_open_components += patch.n_open_components;
        all.n_open_sides += patch.n_open_sides;
        all.open_fans.extend(patch.open_fans);
        all.curves.extend(patch.curves.into_iter().map(|curve| curve.map(|fan| fans + fan)));
        all.open_edges.extend(patch.open_edges.into_iter().map(|edge| OpenEdge {
            fans: edge.fans.map(|fan| fans + fan),
            component: components + edge.component,
            side: sides + edge.side,
            ..edge
        }));
    }

    /// Joins the open elements over shared edges; counts the topology of the whole mesh.
    pub fn count_topology(self) -> Topology {
        let TopologyPatch { mut closed, n_closed_fans, is_one_sided, open_fans, mut open_edges, .. } = self.0;
        open_edges.sort_unstable_by_key(OpenEdge::places);
        let mut open = OpenElements {
            components: UnionFind::new(self.0.n_open_components as usize),
            fans: UnionFind::new(open_fans.len()),
            sides: Windings::new(self.0.n_open_sides as usize),
            curves: self.0.curves,
            all_agree: !is_one_sided,
        };
        for edge in open_edges.chunk_by(|x, y| x.places() == y.places()) {
            open.join(edge, &mut closed);
        }
        closed.components += open.components.n_sets();
        let n_fans = n_closed_fans + open.fans.n_sets();
        let curves: Vec<[u32; 2]> = open.curves.iter().map(|curve| curve.map(|fan| open.fans.find(fan))).collect();
        closed.boundary_loops += curves_through(&curves).1.n_sets();
        let (vertices, non_manifold_vertices) = shared_vertices(&open_fans, &mut open.fans);
        closed.vertices += vertices;
        closed.non_manifold_vertices += non_manifold_vertices;
        closed.finish(n_fans, open.all_agree)
    }
}

struct OpenElements {
    components: UnionFind,
    fans: UnionFind,
    sides: Windings,
    curves: Vec<[u32; 2]>,
    all_agree: bool,
}

impl OpenElements {
    fn join(&mut self, edge: &[OpenEdge], counts: &mut Topology) {
        counts.edges += 1;
        counts.boundary_edges += usize::from(edge.len() == 1);
        counts.non_manifold_edges += usize::from(edge.len() > 2);
        if let [only] = edge {
            self.curves.push(only.fans);
        }
        for pair in edge.windows(2) {
            self.components.union(pair[0].component, pair[1].component);
            let [from, to] = pair[1].fans_along(&pair[0]);
            self.fans.union(pair[0].fans[0], from);
            self.fans.union(pair[0].fans[1], to);
        }
        if let [x, y] = edge {
            let against = x.ends == y.ends;
            counts.inconsistent_edges += usize::from(against);
            self.all_agree &= self.sides.join([x.side, y.side], against ^ x.is_turned ^ y.is_turned);
        }
    }
}

fn shared_vertices(open_fans: &[PositionKey], fans: &mut UnionFind) -> (usize, usize) {
    let mut at: Vec<(PositionKey, u32)> = open_fans.iter().copied().zip((0..).map(|fan| fans.find(fan))).collect();
    at.sort_unstable();
    at.dedup();
    let vertices = at.chunk_by(|(x, _), (y, _)| x == y);
    vertices.fold((0, 0), |(n, several), fans| (n + 1, several + usize::from(fans.len() > 1)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{compact, shapes};
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rand_xoshiro::rand_core::{Rng, SeedableRng};
    use std::collections::{BTreeMap, BTreeSet};

    fn mesh(n_vertices: usize, faces: &[[u32; 3]]) -> TriMesh {
        TriMesh::new(vec![[0.0; 3]; n_vertices], faces.to_vec()).unwrap()
    }

    fn naive_edges(faces: &[[u32; 3]]) -> BTreeMap<(u32, u32), Vec<(usize, bool)>> {
        let mut edges: BTreeMap<_, Vec<_>> = BTreeMap::new();
        for (i, &[a, b, c]) in faces.iter().enumerate() {
            for (a, b) in [(a, b), (b, c), (c, a)] {
                edges.entry((a.min(b), a.max(b))).or_default().push((i, a < b));
            }
        }
        edges
    }

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

    fn in_blocks(n_vertices: u32, faces: &[[u32; 3]], rng: &mut Xoshiro256PlusPlus) -> Topology {
        let positions: Vec<[f32; 3]> = (0..n_vertices).map(|v| [v as f32, 0.0, 0.0]).collect();
        let mut blocks = vec![Vec::new(); 3];
        faces.iter().for_each(|&face| blocks[rng.next_u32() as usize % 3].push(face));
        let users = |v: u32| blocks.iter().filter(|block| block.as_flattened().contains(&v)).count();
        let mut patches = TopologyPatches::default();
        for block in &blocks {
            let (mesh, sources) = compact(&positions, block.clone()).unwrap();
            patches.add(TopologyPatch::new(&mesh, |v| users(sources[v as usize]) > 1));
        }
        patches.count_topology()
    }

    #[test]
    fn blocks_are_joined_to_what_the_whole_is() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(9);
        for round in 0..400 {
            let n = 5 + round % 9;
            let faces: Vec<[u32; 3]> = (0..2 + round % 40).map(|_| [0; 3].map(|_| rng.next_u32() % n)).collect();
            let faces: Vec<_> = faces.into_iter().filter(|&[a, b, c]| a != b && b != c && c != a).collect();
            let unreferenced = (0..n).filter(|v| !faces.as_flattened().contains(v)).count();
            let mut whole = topology(&mesh(n as usize, &faces));
            (whole.vertices, whole.unreferenced_vertices) = (whole.vertices - unreferenced, 0);
            assert_eq!(in_blocks(n, &faces, &mut rng), whole, "{faces:?}");
        }
        for shape in [shapes::torus(8, 6, 1.0, 0.3), shapes::open_cylinder(9, 4), shapes::icosphere(2)] {
            for turned in [0, 3] {
                let mut faces = shape.faces().to_vec();
                faces.iter_mut().take(turned).for_each(|face| face.swap(0, 1));
                let n = shape.positions().len();
                assert_eq!(in_blocks(n as u32, &faces, &mut rng), topology(&mesh(n, &faces)));
            }
        }
    }

    #[test]
    fn a_band_with_one_side_has_one_in_blocks_as_well() {
        // Squares around a ring, the last joined upside down.
        let rung = |i: u32| if i == 12 { [1, 0] } else { [2 * i, 2 * i + 1] };
        let square = |i: u32| (rung(i), rung(i + 1));
        let faces = (0..12).map(square).flat_map(|([a, b], [c, d])| [[a, b, c], [c, b, d]]);
        let faces: Vec<[u32; 3]> = faces.collect();
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(2);
        let whole = topology(&mesh(24, &faces));
        assert!(!whole.orientable && whole.boundary_loops == 1);
        for _ in 0..20 {
            assert_eq!(in_blocks(24, &faces, &mut rng), whole);
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
        // A ring of six faces around vertex 0 without two opposite ones; the boundary passes 0 twice.
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
