//! The largest distance between two surfaces with proof: bounds from below and above, by branch and bound.
//!
//! The distance to a triangle is a convex function, so over a convex part of a face it is largest at a corner. The largest
//! distance of a part to a surface is therefore at most `min over its faces F of max over the corners v of d(v, F)`; the faces
//! nearest to the corners serve as F. A corner's own distance bounds it from below. Parts whose bounds are too far apart are
//! cut, those with the largest upper bound first (after Tang, Lee and Kim 2009, "Interactive Hausdorff distance computation
//! for general polygonal models"). They are cut where the nearest face changes, along the planes through its sides, so that
//! there are about as many parts as pairs of faces that lie over each other: cutting in four, as they do, took four to
//! a hundred and sixty times as long on three meshes, longest on flat parts that agree.

use glam::DVec3;
use rayon::prelude::*;

use crate::mesh::TriMesh;
use crate::spatial::{self, FaceTree};

mod bounds;
mod other;
mod piece;
mod search;

use bounds::Bounds;
pub use bounds::Sharpness;
use other::Other;
use piece::Corner;
use search::{Part, Waiting, tighten};

/// Triangles and boxes looked at, per face of both meshes, after which a direction of the search gives what it has, and those it may
/// look at however few faces there are: the bounds are then farther apart than asked. Two dozen per face are usual; where large faces
/// lie across each other, one search for the nearest looks at many.
const MOST_LOOKS: [u64; 2] = [150, 1_500_000];
/// Distances below this share of the diagonal are not told apart.
const SMALLEST: f64 = 1e-7;

/// Bounds of the largest distance from either surface to the other, in the mesh's unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct CertifiedDistance {
    /// Some point is at least so far from the other surface.
    pub lower: f64,
    /// No point is farther.
    pub upper: f64,
    /// Diagonal of the original's bounding box.
    pub diagonal: f64,
}

/// Bounds the two-sided (Hausdorff) distance; `None` where one of the two has no faces.
///
/// The bounds hold for the coordinates as given, up to rounding in double precision. Below 1e-7 of the diagonal the upper one
/// may be farther from the lower than asked.
///
/// ```
/// use neural_mesh::{mesh::shapes, metrics::{Sharpness, certified_distance}};
/// let distance = certified_distance(&shapes::icosphere(4), &shapes::icosphere(1), &Sharpness::default()).unwrap();
/// assert!(distance.lower > 0.05 && distance.upper <= 1.01 * distance.lower);
/// ```
pub fn certified_distance(original: &TriMesh, simplified: &TriMesh, asked: &Sharpness) -> Option<CertifiedDistance> {
    certified_within(original, simplified, asked, u64::MAX).0
}

/// The same where each direction may look at so much, if that is less than usual; beside it what both have looked at.
pub(crate) fn certified_within(
    original: &TriMesh,
    simplified: &TriMesh,
    asked: &Sharpness,
    most: u64,
) -> (Option<CertifiedDistance>, u64) {
    if original.faces().is_empty() || simplified.faces().is_empty() {
        return (None, 0);
    }
    let diagonal = original.diagonal();
    let asked = Sharpness { enough: asked.enough.max(SMALLEST * diagonal), ..*asked };
    let mut bounds = Bounds { lower: 0.0, upper: 0.0, asked };
    let trees = [simplified, original].map(|mesh| FaceTree::new(mesh.positions(), mesh.faces()));
    let n_faces = original.faces().len() + simplified.faces().len();
    let most = most.min(MOST_LOOKS[0] * n_faces as u64 + MOST_LOOKS[1]);
    let others = [Other::new(original, &trees[1], most), Other::new(simplified, &trees[0], most)];
    // The vertices of both raise the lower bound before either is searched.
    let directions = [simplified, original].into_iter().zip(&others).map(|(from, other)| {
        let direction = Direction::new(from, other, &bounds);
        bounds.raise_to(direction.farthest_vertex());
        direction
    });
    let directions: Vec<Direction> = directions.collect();
    if bounds.is_beyond() {
        bounds.upper = f64::INFINITY;
    } else if directions.iter().all(Direction::is_known) {
        directions.iter().for_each(|direction| direction.search(&mut bounds));
    } else {
        bounds.upper = farthest_apart(original, simplified);
    }
    let n_looks = others.iter().map(Other::n_looks).sum();
    (Some(CertifiedDistance { lower: bounds.lower, upper: bounds.upper.max(bounds.lower), diagonal }), n_looks)
}

/// The largest distance within 1 %: no point of either mesh is farther from the other, and some are nearly as far; `None` where
/// one has no faces, or where large faces lie across each other so that proof takes too long.
///
/// ```
/// use neural_mesh::{mesh::shapes, metrics::largest_distance};
/// let (sphere, radius) = (shapes::icosphere(4), 1.0);
/// let largest = largest_distance(&sphere, &shapes::icosphere(0)).unwrap();
/// assert!((0.2..radius).contains(&largest));
/// ```
pub fn largest_distance(original: &TriMesh, simplified: &TriMesh) -> Option<f64> {
    let asked = Sharpness::default();
    let CertifiedDistance { lower, upper, diagonal } = certified_distance(original, simplified, &asked)?;
    let bounds = Bounds { lower, upper, asked: Sharpness { enough: SMALLEST * diagonal, ..asked } };
    bounds.allow(upper).then_some(upper)
}

/// The largest distance found from some faces of one mesh to the surface under a tree, `lower` where that is more: no farther
/// from the true one than `gap` times it, unless more than so many triangles have to be looked at for that.
pub(super) fn largest_from_faces(
    [from, to]: [&TriMesh; 2],
    faces: &[u32],
    tree: &FaceTree,
    [lower, gap]: [f64; 2],
    most_tests: u64,
) -> f64 {
    let other = Other::new(to, tree, most_tests).of_triangles();
    let mut bounds = Bounds { lower, upper: 0.0, asked: Sharpness { gap, ..Sharpness::default() } };
    let point = |v: u32| DVec3::from(from.positions()[v as usize].map(f64::from));
    let corners_of = |face: u32| from.faces()[face as usize].map(|v| other.corner(point(v), None));
    let whole = |&face: &u32| {
        let upper = other.upper(&corners_of(face), |_| false);
        Waiting { upper, part: Part::Face(face), n_cuts: 0 }
    };
    tighten(faces.iter().map(whole).collect(), &corners_of, &other, &mut bounds);
    bounds.lower
}

/// No two points of two meshes are farther apart.
fn farthest_apart(a: &TriMesh, b: &TriMesh) -> f64 {
    let both = spatial::Bounds::of(a.positions()).union(&spatial::Bounds::of(b.positions()));
    let [low, high] = [both.low, both.high].map(|corner| DVec3::from(corner.map(f64::from)));
    low.distance(high)
}

/// From one mesh to the other.
struct Direction<'a> {
    from: &'a TriMesh,
    other: &'a Other<'a>,
    /// What is known at the vertices, n_vertices unless that cost too much or some are too far.
    corners: Vec<Corner>,
}

impl<'a> Direction<'a> {
    fn new(from: &'a TriMesh, other: &'a Other<'a>, bounds: &Bounds) -> Self {
        Self { from, corners: other.corners_of(from, bounds), other }
    }

    /// Whether all vertices could be looked up.
    fn is_known(&self) -> bool {
        self.corners.len() == self.from.positions().len()
    }

    fn corners_of(&self, face: &[u32; 3]) -> [Corner; 3] {
        face.map(|v| self.corners[v as usize])
    }

    /// The largest distance of a vertex that has a face.
    fn farthest_vertex(&self) -> f64 {
        let corners = self.from.faces().iter().flatten().filter_map(|&v| self.corners.get(v as usize));
        corners.map(|corner| corner.distance).fold(0.0, f64::max)
    }

    /// Tightens the bounds by the distances from the one mesh to the other.
    fn search(&self, bounds: &mut Bounds) {
        if bounds.is_beyond() {
            bounds.upper = f64::INFINITY;
            return;
        }
        let upper = |face: &[u32; 3]| self.other.upper(&self.corners_of(face), |upper| bounds.allow(upper));
        let uppers: Vec<f64> = self.from.faces().par_iter().map(upper).collect();
        let (allowed, faces): (Vec<_>, Vec<_>) = (0..).zip(uppers).partition(|&(_, upper)| bounds.allow(upper));
        bounds.upper = allowed.into_iter().map(|(_, upper)| upper).fold(bounds.upper, f64::max);
        let whole = |(face, upper)| Waiting { upper, part: Part::Face(face), n_cuts: 0 };
        let waiting = faces.into_iter().map(whole).collect();
        let corners_of = |face| self.corners_of(&self.from.faces()[face as usize]);
        tighten(waiting, &corners_of, self.other, bounds);
        if bounds.is_beyond() {
            bounds.upper = f64::INFINITY;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::metrics::{Surface, surface_distance};

    #[test]
    fn samples_never_exceed_the_upper_bound() {
        let pairs = [
            (shapes::bolt(32), shapes::bolt(9)),
            (shapes::torus(64, 32, 1.0, 0.25), shapes::torus(20, 9, 1.0, 0.25)),
            (shapes::wavy_sphere(4, 8.0), shapes::icosphere(2)),
            (shapes::cuboid([1.0; 3], 7), shapes::cuboid([1.0, 1.0, 1.2], 3)),
        ];
        for (a, b) in pairs {
            let certified = certified_distance(&a, &b, &Sharpness::default()).unwrap();
            let sampled =
                surface_distance(&Surface::new(&a, 30_000, 0), &Surface::new(&b, 30_000, 0)).unwrap().both.max;
            assert!(sampled <= certified.upper && certified.upper <= 1.01 * certified.lower, "{certified:?} {sampled}");
            assert!(certified.lower < 1.1 * sampled);
        }
    }

    #[test]
    fn a_known_distance_is_found_between_the_corners() {
        // A square, and the same with its middle pushed up; the middle is no vertex of the first.
        let flat = TriMesh::new(
            vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
            vec![[0, 1, 2], [0, 2, 3]],
        );
        let roof = TriMesh::new(
            vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.5, 2.0]],
            vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]],
        );
        let (flat, roof) = (flat.unwrap(), roof.unwrap());
        for [a, b] in [[&flat, &roof], [&roof, &flat]] {
            let certified = certified_distance(a, b, &Sharpness::default()).unwrap();
            assert!((1.99..2.0001).contains(&certified.lower) && certified.upper < 2.05, "{certified:?}");
        }
    }

    #[test]
    fn equal_meshes_are_at_no_distance() {
        let mesh = shapes::cuboid([1.0; 3], 6);
        let certified = certified_distance(&mesh, &mesh, &Sharpness::default()).unwrap();
        assert!(certified.lower < 1e-9 && certified.upper < 1e-6, "{certified:?}");
        assert!(certified_distance(&mesh, &TriMesh::default(), &Sharpness::default()).is_none());
    }

    #[test]
    fn a_search_that_costs_too_much_says_less_and_nothing_false() {
        let (a, b) = (shapes::wavy_sphere(6, 8.0), shapes::icosphere(3));
        let exact = certified_distance(&a, &b, &Sharpness::default()).unwrap();
        let tree = FaceTree::new(b.positions(), b.faces());
        let bounded = |most| {
            let other = Other::new(&b, &tree, most);
            let mut bounds = Bounds { lower: 0.0, upper: 0.0, asked: Sharpness::default() };
            let direction = Direction::new(&a, &other, &bounds);
            bounds.raise_to(direction.farthest_vertex());
            direction.is_known().then(|| direction.search(&mut bounds));
            (direction.is_known(), bounds.lower, bounds.upper)
        };
        let (is_known, lower, _) = bounded(10);
        assert!(!is_known && lower > 0.0 && lower <= exact.upper);
        assert!(farthest_apart(&a, &b) >= exact.lower);
        // Enough for the vertices, not for the faces.
        let (is_known, lower, upper) = bounded(2_000_000);
        assert!(is_known && lower <= exact.upper && upper >= exact.lower, "{lower} {upper} {exact:?}");
        let largest = largest_from_faces([&a, &b], &[0, 1, 2], &tree, [0.0, 0.01], 1);
        assert!(largest <= exact.upper);
    }

    #[test]
    fn a_limit_ends_the_search_early() {
        let (a, b) = (shapes::wavy_sphere(5, 8.0), shapes::icosphere(2));
        let exact = certified_distance(&a, &b, &Sharpness::default()).unwrap();
        let within = Sharpness { enough: 2.0 * exact.upper, too_much: 2.0 * exact.upper, ..Sharpness::default() };
        assert!(certified_distance(&a, &b, &within).unwrap().upper <= 2.0 * exact.upper + 1e-6);
        let beyond = Sharpness { enough: 0.5 * exact.lower, too_much: 0.5 * exact.lower, ..Sharpness::default() };
        assert_eq!(certified_distance(&a, &b, &beyond).unwrap().upper, f64::INFINITY);
        // Some vertices are enough for that, but none that no face uses.
        let looks = |asked: &Sharpness| certified_within(&a, &b, asked, u64::MAX).1;
        assert!(looks(&beyond) < looks(&within) / 3, "{} {}", looks(&beyond), looks(&within));
        let mut positions = b.positions().to_vec();
        positions.insert(0, [9.0; 3]);
        let faces = b.faces().iter().map(|face| face.map(|v| v + 1)).collect();
        let with_stray = TriMesh::new(positions, faces).unwrap();
        assert!(certified_distance(&a, &with_stray, &within).unwrap().upper <= 2.0 * exact.upper + 1e-6);
    }
}
