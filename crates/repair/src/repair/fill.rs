//! Fills holes.

use std::cmp::Reverse;

use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::mesh::half_edges::for_each_edge;
use crate::mesh::{Attributes, TriMesh};
use crate::parallel;

use super::cover::{Outline, cover};
use super::faces::{FaceOrigin, RepairFaces};
use super::loops::{Rim, loops};
use super::{RepairCounts, Repaired};

/// Candidates for the number of edges up to which loops are triangulated optimally.
const BEST: [usize; 4] = [256, 128, 64, 32];
/// Largest number of dynamic programming steps: a few seconds on one core.
const STEPS: usize = 1 << 27;

#[derive(Clone, Copy, Debug)]
pub(super) struct Holes {
    pub n_filled: usize,
    pub n_left: usize,
}

/// Closes each boundary loop that has at most `most_edges` edges.
///
/// The boundary is that of the manifold into which the faces are cut. A mesh with a boundary is first wound
/// consistently. New corners get the attributes of a neighbour, and all faces over a hole the most frequent group
/// around it. Longer loops, and the boundary of a single face, stay open.
///
/// ```
/// # use neural_mesh_repair as neural_mesh;
/// use neural_mesh::mesh::{Attributes, shapes, topology};
/// use neural_mesh::repair::fill_holes;
/// let filled = fill_holes(&shapes::open_cylinder(12, 3), Attributes::NONE, usize::MAX);
/// assert_eq!((filled.counts.holes_filled, filled.counts.faces_added), (2, 20));
/// assert!(topology(&filled.mesh).is_closed_manifold());
/// ```
pub fn fill_holes(mesh: &TriMesh, attributes: &Attributes, most_edges: usize) -> Repaired {
    fill_some_holes(mesh, attributes, most_edges, |_| true)
}

/// Closes those loops, as [`fill_holes`] does, whose vertices in loop order `is_wanted` accepts.
pub fn fill_some_holes(
    mesh: &TriMesh,
    attributes: &Attributes,
    most_edges: usize,
    is_wanted: impl Fn(&[u32]) -> bool,
) -> Repaired {
    let mut faces = RepairFaces::new(mesh, attributes);
    let holes = fill(&mut faces, most_edges, |rims| is_wanted(&rims.iter().map(|rim| rim.vertex).collect::<Vec<_>>()));
    let counts = RepairCounts { holes_filled: holes.n_filled, holes_left: holes.n_left, ..RepairCounts::default() };
    faces.into_repaired(attributes, counts)
}

pub(super) fn fill(faces: &mut RepairFaces, most_edges: usize, is_wanted: impl Fn(&[Rim]) -> bool) -> Holes {
    let loops: Vec<Vec<Rim>> = loops(faces).into_iter().filter(|rims| is_wanted(rims)).collect();
    // The boundary of a lone triangle: filling would only double it.
    let is_single = |rims: &[Rim]| rims.len() == 3 && rims.iter().all(|rim| rim.face() == rims[0].face());
    let n_loops = loops.len();
    let holes: Vec<Vec<Rim>> = loops.into_iter().filter(|rims| rims.len() <= most_edges && !is_single(rims)).collect();
    // The covers avoid these edges: an edge made twice would get four faces.
    let known = edges_between(faces, holes.iter().flatten().map(|rim| rim.vertex));
    let lengths: Vec<usize> = holes.iter().map(Vec::len).collect();
    let n_best = n_best(&lengths);
    // In parallel; holes are independent of each other.
    let covered = parallel::each(&holes, |rims| triangles_over(faces, rims, &known, n_best));
    for (rims, triangles) in holes.iter().zip(covered) {
        // One group per hole, so that no seam runs across it.
        let group = most_common(rims.iter().map(|rim| faces.group(rim.face())));
        for triangle in triangles {
            let wedges = triangle.map(|i| wedge_at_side(faces, rims, triangle, i));
            faces.push(triangle.map(|i| rims[i as usize].vertex), wedges, group);
        }
    }
    Holes { n_filled: holes.len(), n_left: n_loops - holes.len() }
}

fn n_best(lengths: &[usize]) -> usize {
    let steps = |n_best: usize| -> usize {
        lengths.iter().map(|&n| n.min(n_best)).map(|n| n * n * n / 6).fold(0, usize::saturating_add)
    };
    BEST.into_iter().find(|&n| steps(n) <= STEPS).unwrap_or(3)
}

fn edges_between(faces: &RepairFaces, vertices: impl Iterator<Item = u32>) -> FxHashSet<[u32; 2]> {
    let mut is_one = vec![false; faces.positions.len()];
    vertices.for_each(|vertex| is_one[vertex as usize] = true);
    let mut edges = FxHashSet::default();
    for_each_edge(faces.positions.len(), &faces.corners, |ends, _| {
        if ends.iter().all(|&vertex| is_one[vertex as usize]) {
            edges.insert(ends);
        }
    });
    edges
}

fn triangles_over(faces: &RepairFaces, rims: &[Rim], known: &FxHashSet<[u32; 2]>, n_best: usize) -> Vec<[u32; 3]> {
    let is_edge = |i: u32, k: u32| {
        let [a, b] = [i, k].map(|i| rims[i as usize].vertex);
        known.contains(&[a.min(b), a.max(b)])
    };
    let normal = |rim: &Rim| {
        // The normal is turned as if the face traversed the edge in the loop's direction.
        let normal = faces.normal(rim.face()).normalize_or_zero();
        if rim.is_along(faces) { normal } else { -normal }
    };
    let points: Vec<DVec3> = rims.iter().map(|rim| faces.position(rim.vertex)).collect();
    let normals = rims.iter().map(normal).collect();
    cover(&Outline { points, normals, is_edge: &is_edge }, n_best)
}

/// Returns the wedge for a corner of a new face, preferably from the face across one of the corner's sides.
fn wedge_at_side(faces: &RepairFaces, rims: &[Rim], triangle: [u32; 3], i: u32) -> u32 {
    let n = rims.len() as u32;
    let before = (i + n - 1) % n;
    let is_side = |place: u32| triangle.contains(&place);
    let rim = rims[if is_side(before) && !is_side((i + 1) % n) { before } else { i } as usize];
    faces.wedge_at(rim.face(), rims[i as usize].vertex)
}

fn most_common(numbers: impl Iterator<Item = u32>) -> u32 {
    let mut counts: FxHashMap<u32, usize> = FxHashMap::default();
    numbers.for_each(|number| *counts.entry(number).or_default() += 1);
    counts.into_iter().max_by_key(|&(number, n)| (n, Reverse(number))).map_or(0, |(number, _)| number)
}

pub(super) fn areas(faces: &RepairFaces, some: impl Iterator<Item = u32>) -> [f64; 2] {
    some.fold([0.0; 2], |mut sums, face| {
        sums[usize::from(faces.origins[face as usize] != FaceOrigin::New)] += faces.area(face);
        sums
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Channel, Role, edges, shapes, topology};
    use proptest::prelude::*;

    fn remove_faces(mesh: &TriMesh, gone: &[usize]) -> TriMesh {
        let n = mesh.faces().len();
        let gone: FxHashSet<usize> = gone.iter().map(|g| g % n).collect();
        let faces = mesh.faces().iter().enumerate().filter(|(f, _)| !gone.contains(f)).map(|(_, &face)| face);
        TriMesh::new(mesh.positions().to_vec(), faces.collect()).unwrap()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn whatever_is_cut_out_is_closed_again(gone in prop::collection::vec(any::<usize>(), 0..200), which in 0usize..3) {
            let mesh = [shapes::icosphere(2), shapes::torus(16, 8, 2.0, 0.7), shapes::cuboid([1.0, 2.0, 3.0], 4)][which].clone();
            let filled = fill_holes(&remove_faces(&mesh, &gone), Attributes::NONE, usize::MAX);
            // A single face that is left open has a boundary, at which others may end.
            let n_odd = edges(&filled.mesh).iter().filter(|edge| (edge.up + edge.down) % 2 == 1).count();
            prop_assert!(n_odd <= 3 * filled.counts.holes_left);
            prop_assert!(n_odd > 0 || fill_holes(&filled.mesh, Attributes::NONE, usize::MAX).counts == RepairCounts::default());
        }
    }

    #[test]
    fn loops_longer_than_asked_for_stay() {
        let holed = remove_faces(&shapes::cuboid([1.0; 3], 6), &[5, 6, 7, 30]);
        let few = fill_holes(&holed, Attributes::NONE, 3);
        assert!(few.counts.holes_filled >= 1 && few.counts.holes_left >= 1, "{:?}", few.counts);
        let all = fill_holes(&holed, Attributes::NONE, usize::MAX);
        assert_eq!(all.counts.holes_filled, few.counts.holes_filled + few.counts.holes_left);
        assert!(topology(&all.mesh).is_closed_manifold());
    }

    #[test]
    fn a_flat_hole_is_filled_flat_and_outward() {
        // A cube without its top.
        let cube = shapes::cuboid([1.0; 3], 4);
        let high = cube.positions().iter().map(|p| p[2]).fold(f32::MIN, f32::max);
        let is_top = |face: &[u32; 3]| face.iter().all(|&v| cube.positions()[v as usize][2] == high);
        let gone: Vec<usize> = (0..cube.faces().len()).filter(|&f| is_top(&cube.faces()[f])).collect();
        let filled = fill_holes(&remove_faces(&cube, &gone), Attributes::NONE, usize::MAX);
        assert!(topology(&filled.mesh).is_closed_manifold());
        let volume = crate::metrics::volume(&filled.mesh).unwrap();
        assert!((volume - 1.0).abs() < 1e-6, "{volume}");
    }

    #[test]
    fn a_single_face_is_left() {
        let triangle = TriMesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]).unwrap();
        let left = fill_holes(&triangle, Attributes::NONE, usize::MAX);
        assert_eq!((left.mesh, left.counts.holes_left), (triangle, 1));
    }

    #[test]
    fn new_faces_take_attributes_of_their_neighbours() {
        let mesh = remove_faces(&shapes::grid(6, 6), &[]);
        let n = mesh.faces().len();
        let values = (0..mesh.positions().len()).map(|v| v as f32).collect();
        let channel = Channel { name: "a".into(), role: Role::Other, width: 1, values };
        let attributes = Attributes {
            wedges: mesh.faces().to_vec(),
            channels: vec![channel],
            groups: (0..n as u32).map(|f| f % 3).collect(),
        };
        let filled = fill_holes(&mesh, &attributes, usize::MAX);
        assert!(filled.attributes.is_valid_for(filled.mesh.faces().len()));
        for (face, wedges) in filled.mesh.faces().iter().zip(&filled.attributes.wedges) {
            assert_eq!(face, wedges);
        }
        assert!(filled.attributes.groups[n..].windows(2).all(|pair| pair[0] == pair[1]));
    }

    #[test]
    fn many_loops_share_the_steps() {
        assert_eq!((n_best(&[100; 10]), n_best(&[300; 2]), n_best(&[])), (256, 256, 256));
        assert!(n_best(&[256; 100_000]) <= 32);
    }
}
