//! Faces that are an orientable manifold with boundary while they are added one by one.

use super::planes::point;
use rustc_hash::FxHashMap;

/// Cosine of the least angle between neighbouring faces of the surface.
const LEAST_ANGLE: f64 = 0.7;

/// Mark of a missing face.
pub(super) const NO_FACE: u32 = u32::MAX;

/// Faces over points, at most two per edge, that can be wound alike.
///
/// The faces at a vertex are fans, or one disk.
pub struct ManifoldFaces<'a> {
    pub(super) points: &'a [[f32; 3]],
    pub(super) faces: Vec<[u32; 3]>,
    /// Faces at each edge, [`NO_FACE`] second where there is only one.
    pub(super) at_edges: FxHashMap<[u32; 2], [u32; 2]>,
    /// Edges opposite to each vertex in its faces.
    links: Vec<Vec<[u32; 2]>>,
    sides: Sides,
}

impl<'a> ManifoldFaces<'a> {
    /// Starts without faces; `points`: n x 3.
    pub fn new(points: &'a [[f32; 3]]) -> Self {
        let (links, sides) = (vec![Vec::new(); points.len()], Sides::default());
        Self { points, faces: Vec::new(), at_edges: FxHashMap::default(), links, sides }
    }

    /// Adds a face as [`add`](Self::add) does, unless it is folded onto a neighbour.
    pub fn add_unfolded(&mut self, face: [u32; 3]) -> bool {
        let across = self.faces_across(face);
        let edges = edges_with_apex(face).into_iter().zip(across);
        edges.filter(|(_, [other, _])| *other != NO_FACE).all(|(edge, [other, _])| self.is_unfolded(edge, other))
            && self.add(face)
    }

    /// Adds a face unless the faces would be no manifold then; returns whether it was added.
    pub fn add(&mut self, face: [u32; 3]) -> bool {
        let across = self.faces_across(face);
        let keeps_manifold = across.iter().all(|faces| faces[1] == NO_FACE)
            && edges_with_apex(face).iter().all(|&[a, b, apex]| self.keeps_disk(apex, [a, b]));
        if !keeps_manifold {
            return false;
        }
        let edges = edges_of(face);
        let is_against = |other: u32, edge: &[u32; 2]| edges_of(self.faces[other as usize]).contains(edge);
        let neighbours = across.iter().zip(&edges).filter(|(faces, _)| faces[0] != NO_FACE);
        let neighbours: Vec<_> = neighbours.map(|([other, _], edge)| (*other, is_against(*other, edge))).collect();
        if !self.sides.join_new(&neighbours) {
            return false;
        }
        let number = self.faces.len() as u32;
        for (edge, faces) in edges.into_iter().zip(across) {
            let place = usize::from(faces[0] != NO_FACE);
            self.at_edges.entry(edge_key(edge)).or_insert([NO_FACE; 2])[place] = number;
        }
        edges_with_apex(face).into_iter().for_each(|[a, b, apex]| self.links[apex as usize].push([a, b]));
        self.faces.push(face);
        true
    }

    /// Lists the faces, neighbours wound alike.
    pub fn list_wound_faces(&mut self) -> Vec<[u32; 3]> {
        let Self { faces, sides, .. } = self;
        let wind = |(at, &[a, b, c]): (u32, &[u32; 3])| if sides.find(at).1 { [a, c, b] } else { [a, b, c] };
        (0..).zip(faces.iter()).map(wind).collect()
    }

    /// Returns a face of the component of each face, the same for all of its faces.
    pub fn components(&mut self) -> Vec<u32> {
        (0..self.faces.len() as u32).map(|face| self.sides.find(face).0).collect()
    }

    /// Returns whether the boundary passes a vertex more than once.
    pub(super) fn is_pinched(&self, v: u32) -> bool {
        let ends = self.links[v as usize].as_flattened();
        ends.iter().filter(|&&w| self.at_edges[&edge_key([v, w])][1] == NO_FACE).count() > 2
    }

    fn faces_across(&self, face: [u32; 3]) -> [[u32; 2]; 3] {
        edges_of(face).map(|edge| self.at_edges.get(&edge_key(edge)).copied().unwrap_or([NO_FACE; 2]))
    }

    fn is_unfolded(&self, [a, b, apex]: [u32; 3], other: u32) -> bool {
        let opposite = self.faces[other as usize].into_iter().find(|&v| v != a && v != b).unwrap_or(apex);
        let start = point(self.points, a);
        let along = (point(self.points, b) - start).normalize_or_zero();
        // Directions from the edge into both faces.
        let [one, two] = [apex, opposite].map(|v| point(self.points, v) - start).map(|d| d - d.dot(along) * along);
        one.normalize_or_zero().dot(two.normalize_or_zero()) < LEAST_ANGLE
    }

    /// Returns whether the faces at `v`, with one more over the edge `a`-`b`, still are fans, or one disk.
    fn keeps_disk(&self, v: u32, [a, b]: [u32; 2]) -> bool {
        let link = &self.links[v as usize];
        let degree = |w: u32| link.iter().filter(|edge| edge.contains(&w)).count();
        if link.len() > 2 && link.as_flattened().iter().all(|&w| degree(w) == 2) {
            return false;
        }
        // Along the fan that ends at `a`; where its other end is `b`, the new face closes it.
        let (mut end, mut last, mut n) = (a, usize::MAX, 0);
        while let Some(next) = (0..link.len()).find(|&i| i != last && link[i].contains(&end)) {
            (end, last, n) = (link[next][usize::from(link[next][0] == end)], next, n + 1);
        }
        n == 0 || end != b || n == link.len()
    }
}

/// Which faces are turned over: a union-find with parities.
#[derive(Default)]
struct Sides {
    /// Parent of each face, and whether it is turned against it.
    parent: Vec<(u32, bool)>,
}

impl Sides {
    /// Adds a face with neighbours, each with whether it must be turned against it; returns whether that is possible.
    fn join_new(&mut self, neighbours: &[(u32, bool)]) -> bool {
        let mut to_root = |&(face, is_against): &(u32, bool)| {
            let (root, is_turned) = self.find(face);
            (root, is_turned ^ is_against)
        };
        let roots: Vec<(u32, bool)> = neighbours.iter().map(&mut to_root).collect();
        // Two neighbours of one component must agree, or the component would have one side.
        let is_possible = roots.iter().all(|a| roots.iter().all(|b| a.0 != b.0 || a.1 == b.1));
        if is_possible {
            let new = self.parent.len() as u32;
            self.parent.push((new, false));
            roots.into_iter().for_each(|(root, is_turned)| self.parent[root as usize] = (new, is_turned));
        }
        is_possible
    }

    /// Returns the root of a face, and whether the face is turned against it.
    fn find(&mut self, face: u32) -> (u32, bool) {
        let (mut root, mut is_turned) = (face, false);
        while self.parent[root as usize].0 != root {
            let (above, turn) = self.parent[root as usize];
            (root, is_turned) = (above, is_turned ^ turn);
        }
        // Shortens the path, so that the next search is fast.
        let (mut at, mut turn) = (face, is_turned);
        while at != root {
            let (above, step) = std::mem::replace(&mut self.parent[at as usize], (root, turn));
            (at, turn) = (above, turn ^ step);
        }
        (root, is_turned)
    }
}

pub(super) fn edges_of([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// Lists the edges of a face, each with the corner opposite to it.
fn edges_with_apex([a, b, c]: [u32; 3]) -> [[u32; 3]; 3] {
    [[a, b, c], [b, c, a], [c, a, b]]
}

pub(super) fn edge_key([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{TriMesh, shapes, topology};
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn whatever_is_added_stays_an_orientable_manifold(
            faces in prop::collection::vec([0u32..9, 0..9, 0..9], 1..200),
            is_unfolded: bool,
        ) {
            let points: Vec<[f32; 3]> = shapes::icosphere(1).positions()[..9].to_vec();
            let mut manifold = ManifoldFaces::new(&points);
            for face in faces.into_iter().filter(|[a, b, c]| a != b && b != c && c != a) {
                if is_unfolded { manifold.add_unfolded(face) } else { manifold.add(face) };
            }
            let figures = topology(&TriMesh::new(points.clone(), manifold.list_wound_faces()).unwrap());
            prop_assert_eq!((figures.non_manifold_edges, figures.inconsistent_edges), (0, 0));
            let pinched = (0..9).filter(|&v| manifold.is_pinched(v)).count();
            prop_assert!(figures.non_manifold_vertices <= pinched, "{:?}", figures);
        }
    }

    #[test]
    fn all_faces_of_a_manifold_are_added_in_any_order() {
        let torus = shapes::torus(12, 8, 2.0, 1.0);
        for stride in [1, 5, 77] {
            let mut manifold = ManifoldFaces::new(torus.positions());
            let n = torus.faces().len();
            // Every second face is turned.
            let face = |i: usize| match torus.faces()[i * stride % n] {
                [a, b, c] if i.is_multiple_of(2) => [a, c, b],
                face => face,
            };
            assert!((0..n).all(|i| manifold.add_unfolded(face(i))), "{stride}");
            let mesh = TriMesh::new(torus.positions().to_vec(), manifold.list_wound_faces()).unwrap();
            assert!(topology(&mesh).is_closed_manifold() && topology(&mesh).inconsistent_edges == 0);
            assert!(manifold.components().iter().all(|&root| root == manifold.components()[0]));
        }
    }

    #[test]
    fn the_last_face_of_a_moebius_strip_is_refused() {
        let strip = shapes::moebius_strip(20, 3);
        let mut manifold = ManifoldFaces::new(strip.positions());
        let n_added = strip.faces().iter().filter(|&&face| manifold.add(face)).count();
        assert!(n_added < strip.faces().len());
    }

    #[test]
    fn a_face_on_its_neighbour_is_folded() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.5, 1.0, 0.0], [0.5, 0.9, 0.1], [0.5, -1.0, 0.0]];
        let mut manifold = ManifoldFaces::new(&points);
        assert!(manifold.add([0, 1, 2]) && !manifold.add_unfolded([0, 1, 3]) && manifold.add_unfolded([0, 1, 4]));
        assert!(!manifold.add([0, 1, 3]));
    }
}
