//! Boundary loops.

use std::collections::hash_map::Entry;

use rustc_hash::FxHashMap;

use crate::mesh::half_edges::{NO_TWIN, next, start, twins};
use crate::mesh::manifold;

use super::faces::RepairFaces;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rim {
    /// Vertex where the edge starts in the loop.
    pub vertex: u32,
    pub half_edge: u32,
}

impl Rim {
    pub fn face(self) -> u32 {
        self.half_edge / 3
    }

    /// Returns whether the loop and the face traverse the edge in the same direction.
    pub fn is_along(self, faces: &RepairFaces) -> bool {
        start(&faces.corners, self.half_edge) == self.vertex
    }
}

/// Finds the boundary loops of the manifold into which the faces are cut.
///
/// Each loop has at least three edges and passes no vertex twice. Reverses the faces that the cut reverses.
pub(super) fn loops(faces: &mut RepairFaces) -> Vec<Vec<Rim>> {
    let cut = manifold(faces.positions, &faces.corners);
    if cut.rings.n_ghosts() == 0 {
        return Vec::new();
    }
    let (n_vertices, copies) = (faces.positions.len(), cut.copies);
    let vertex_of = |v: u32| (v as usize).checked_sub(n_vertices).map_or(v, |copy| copies[copy]);
    let corners = cut.faces.into_owned();
    let n_split = n_vertices + copies.len();
    let turned: Vec<u32> =
        faces.numbers().filter(|&f| vertex_of(corners[f as usize][1]) != faces.corners[f as usize][1]).collect();
    // Agree with the cut, so that new faces fit both sides.
    turned.into_iter().for_each(|face| faces.turn(face));
    let walks = walks(&corners, &twins(n_split, &corners), n_split);
    let rims = |walk: Vec<(u32, u32)>| -> Vec<Rim> {
        walk.into_iter().map(|(vertex, half_edge)| Rim { vertex: vertex_of(vertex), half_edge }).collect()
    };
    walks.into_iter().flat_map(|walk| split_into_simple_loops(rims(walk))).filter(|rims| rims.len() > 2).collect()
}

fn walks(corners: &[[u32; 3]], twins: &[u32], n_vertices: usize) -> Vec<Vec<(u32, u32)>> {
    // The two boundary half-edges at each boundary vertex.
    let mut sides = vec![[NO_TWIN; 2]; n_vertices];
    let open = || (0..).zip(twins).filter(|(_, twin)| **twin == NO_TWIN).map(|(half_edge, _): (u32, _)| half_edge);
    let ends = |half_edge: u32| [half_edge, next(half_edge)].map(|corner| start(corners, corner));
    for half_edge in open() {
        for vertex in ends(half_edge) {
            let [first, second] = &mut sides[vertex as usize];
            *(if *first == NO_TWIN { first } else { second }) = half_edge;
        }
    }
    // In the manifold every boundary vertex has two sides, so walks close.
    let mut is_walked = vec![false; twins.len()];
    let mut walks = Vec::new();
    for first in open() {
        let (mut half_edge, mut vertex) = (first, start(corners, first));
        let mut walk = Vec::new();
        while half_edge != NO_TWIN && !std::mem::replace(&mut is_walked[half_edge as usize], true) {
            walk.push((vertex, half_edge));
            let [a, b] = ends(half_edge);
            vertex = if vertex == a { b } else { a };
            let [g, h] = sides[vertex as usize];
            half_edge = if g == half_edge { h } else { g };
        }
        walks.extend(Some(walk).filter(|walk| !walk.is_empty()));
    }
    walks
}

fn split_into_simple_loops(walk: Vec<Rim>) -> Vec<Vec<Rim>> {
    let mut loops = Vec::new();
    let mut path: Vec<Rim> = Vec::new();
    let mut place_of: FxHashMap<u32, usize> = FxHashMap::default();
    for rim in walk {
        match place_of.entry(rim.vertex) {
            Entry::Occupied(place) => {
                // The walk is back at a vertex: the edges since then are a loop of their own.
                let cut = path.split_off(*place.get());
                cut.iter().for_each(|rim| _ = place_of.remove(&rim.vertex));
                loops.push(cut);
            }
            Entry::Vacant(_) => {}
        }
        place_of.insert(rim.vertex, path.len());
        path.push(rim);
    }
    loops.push(path);
    loops
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Attributes, TriMesh, shapes};

    fn lengths(mesh: &TriMesh) -> Vec<usize> {
        let mut lengths: Vec<usize> =
            loops(&mut RepairFaces::new(mesh, &Attributes::default())).iter().map(Vec::len).collect();
        lengths.sort_unstable();
        lengths
    }

    #[test]
    fn loops_of_known_surfaces() {
        assert_eq!(lengths(&shapes::grid(3, 4)), [14]);
        assert_eq!(lengths(&shapes::open_cylinder(12, 3)), [12, 12]);
        assert!(lengths(&shapes::icosphere(2)).is_empty() && lengths(&shapes::touching_spheres(2)).is_empty());
        assert_eq!(lengths(&shapes::moebius_strip(20, 3)).len(), 1);
    }

    #[test]
    fn a_loop_that_touches_itself_is_two() {
        let sphere = shapes::icosphere(2);
        let first = sphere.faces()[0];
        let share = |face: &[u32; 3]| face.iter().filter(|v| first.contains(v)).count();
        let second = sphere.faces().iter().position(|face| share(face) == 1).unwrap();
        let faces = sphere.faces().iter().enumerate().filter(|(f, _)| *f != 0 && *f != second);
        let mesh = TriMesh::new(sphere.positions().to_vec(), faces.map(|(_, &face)| face).collect()).unwrap();
        assert_eq!(lengths(&mesh), [3, 3]);
    }

    #[test]
    fn loops_run_as_their_faces_do() {
        let mesh = shapes::open_cylinder(12, 3);
        let mut faces = RepairFaces::new(&mesh, &Attributes::default());
        for rims in loops(&mut faces) {
            for (i, rim) in rims.iter().enumerate() {
                assert!(rim.is_along(&faces));
                assert_eq!(start(&faces.corners, next(rim.half_edge)), rims[(i + 1) % rims.len()].vertex);
            }
        }
    }
}
