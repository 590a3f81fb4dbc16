//! Proved bounds of the largest distance between two surfaces, by branch and bound.
//!
//! The distance to a triangle is convex, so over a convex polygon it is largest at a corner. The largest distance from
//! a polygon to a surface is thus at most `min over faces F of max over corners v of d(v, F)`. Each corner's own
//! distance is a lower bound. Polygons whose bounds are too far apart are cut, largest upper bound first (after Tang,
//! Lee and Kim 2009, "Interactive Hausdorff distance computation for general polygonal models").

use glam::{DVec3, Vec3};

use crate::mesh::{TriMesh, has_area};
use crate::parallel;
use crate::spatial::{self, FaceTree};

mod distance_bounds;
mod polygon;
mod search;
mod target_surface;

use distance_bounds::DistanceBounds;
pub use distance_bounds::DistanceTolerance;
use polygon::PolygonCorner;
use search::{FacePart, SearchItem, tighten_bounds};
use target_surface::TargetSurface;

/// Largest number of triangles and boxes visited per direction: per face, plus a fixed number.
const MAX_VISITS: [u64; 2] = [150, 1_500_000];
/// Share of the diagonal below which distances are not resolved.
const SMALLEST: f64 = 1e-7;
/// Faces that a thread takes at least.
const LEAST: usize = 64;

/// Bounds of the Hausdorff distance, in the mesh's unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CertifiedDistance {
    /// Lower bound: the distance of some point.
    pub lower: f64,
    /// Proved upper bound for all points.
    pub upper: f64,
    /// Diagonal of the original's bounding box.
    pub diagonal: f64,
}

/// Bounds the Hausdorff distance; `None` if a mesh has no faces.
///
/// Faces without area are not measured, unless a mesh has no others; distances to them count.
///
/// The bounds may be farther apart than the tolerance if the search exceeds its budget, or below 1e-7 of the diagonal.
///
/// ```
/// # use neural_mesh_measure as neural_mesh;
/// use neural_mesh::{mesh::shapes, metrics::{DistanceTolerance, certified_distance}};
/// let distance = certified_distance(&shapes::icosphere(4), &shapes::icosphere(1), &DistanceTolerance::default()).unwrap();
/// assert!(distance.lower > 0.05 && distance.upper <= 1.01 * distance.lower);
/// ```
pub fn certified_distance(
    original: &TriMesh,
    simplified: &TriMesh,
    tolerance: &DistanceTolerance,
) -> Option<CertifiedDistance> {
    let [own, other] = [original, simplified].map(|mesh| FaceTree::new(mesh.positions(), mesh.faces()));
    certified_distance_by_trees([original, simplified], [&own, &other], (tolerance, 0.0), u64::MAX).0
}

/// Bounds the distance by at most `most` visits per direction, with the trees of both meshes and a known lower bound.
///
/// Also returns the number of visits.
pub(super) fn certified_distance_by_trees(
    [original, simplified]: [&TriMesh; 2],
    [own, other]: [&FaceTree; 2],
    (tolerance, lower): (&DistanceTolerance, f64),
    most: u64,
) -> (Option<CertifiedDistance>, u64) {
    if original.faces().is_empty() || simplified.faces().is_empty() {
        return (None, 0);
    }
    let diagonal = original.diagonal();
    let tolerance = DistanceTolerance { enough: tolerance.enough.max(SMALLEST * diagonal), ..*tolerance };
    let mut bounds = DistanceBounds { lower, upper: 0.0, tolerance };
    let n_faces = original.faces().len() + simplified.faces().len();
    let most = most.min(MAX_VISITS[0] * n_faces as u64 + MAX_VISITS[1]);
    let targets = [TargetSurface::new(original, own, most), TargetSurface::new(simplified, other, most)];
    // The vertices of both meshes raise the lower bound before the searches.
    let directions = [(simplified, other), (original, own)].into_iter().zip(&targets).map(|(from, target)| {
        let direction = DirectedSearch::new(from, target, &bounds);
        bounds.raise_lower(direction.farthest_vertex);
        direction
    });
    let directions: Vec<DirectedSearch> = directions.collect();
    if bounds.is_too_far() {
        bounds.upper = f64::INFINITY;
    } else if directions.iter().all(|direction| direction.has_all_corners) {
        directions.iter().for_each(|direction| direction.search(&mut bounds));
    } else {
        bounds.upper = farthest_apart(original, simplified);
    }
    let n_visits = targets.iter().map(TargetSurface::n_visits).sum();
    (Some(CertifiedDistance { lower: bounds.lower, upper: bounds.upper.max(bounds.lower), diagonal }), n_visits)
}

/// Returns a proved upper bound of the largest distance, within 1 % of the true one.
///
/// `None` if a mesh has no faces or the proof exceeds the budget.
///
/// ```
/// # use neural_mesh_measure as neural_mesh;
/// use neural_mesh::{mesh::shapes, metrics::largest_distance};
/// let (sphere, radius) = (shapes::icosphere(4), 1.0);
/// let largest = largest_distance(&sphere, &shapes::icosphere(0)).unwrap();
/// assert!((0.2..radius).contains(&largest));
/// ```
pub fn largest_distance(original: &TriMesh, simplified: &TriMesh) -> Option<f64> {
    let tolerance = DistanceTolerance::default();
    let CertifiedDistance { lower, upper, diagonal } = certified_distance(original, simplified, &tolerance)?;
    let bounds =
        DistanceBounds { lower, upper, tolerance: DistanceTolerance { enough: SMALLEST * diagonal, ..tolerance } };
    bounds.is_tight_enough(upper).then_some(upper)
}

/// Returns the largest distance from `faces` of one mesh to the other, or `lower` if that is larger.
///
/// Accurate to the relative `gap`, unless that takes more than `most_tests` triangle tests.
pub(super) fn largest_distance_from_faces(
    [from, to]: [&TriMesh; 2],
    faces: &[u32],
    tree: &FaceTree,
    [lower, gap]: [f64; 2],
    most_tests: u64,
) -> f64 {
    let target = TargetSurface::new(to, tree, most_tests).counting_triangles_only();
    let mut bounds =
        DistanceBounds { lower, upper: 0.0, tolerance: DistanceTolerance { gap, ..DistanceTolerance::default() } };
    let point = |v: u32| DVec3::from(from.positions()[v as usize].map(f64::from));
    let corners_of = |face: u32| from.faces()[face as usize].map(|v| target.corner(point(v), None));
    let whole = |&face: &u32| {
        let upper = target.upper_bound(&corners_of(face), |_| false);
        SearchItem { upper, part: FacePart::Face(face), n_cuts: 0 }
    };
    tighten_bounds(faces.iter().map(whole).collect(), &corners_of, &target, &mut bounds);
    bounds.lower
}

/// Selects those of a list of faces that have an area; all of them if none has.
///
/// A face without area is invisible where it does not lie on the sides of other faces.
pub(super) fn measured_faces(mesh: &TriMesh, faces: &[u32]) -> Vec<u32> {
    let corners = |face: u32| mesh.faces()[face as usize].map(|v| mesh.positions()[v as usize].map(f64::from));
    let with_area: Vec<u32> = faces.iter().copied().filter(|&face| has_area(corners(face))).collect();
    if with_area.is_empty() { faces.to_vec() } else { with_area }
}

fn farthest_apart(a: &TriMesh, b: &TriMesh) -> f64 {
    let both = spatial::Bounds::from_points(a.positions()).union(&spatial::Bounds::from_points(b.positions()));
    let [low, high] = [both.low, both.high].map(|corner| Vec3::from(corner).as_dvec3());
    low.distance(high)
}

struct DirectedSearch<'a> {
    from: &'a TriMesh,
    /// Measured faces, ascending.
    faces: Vec<u32>,
    target: &'a TargetSurface<'a>,
    /// Corner at each vertex of a face.
    corners: Vec<PolygonCorner>,
    farthest_vertex: f64,
    /// True if each such vertex was measured.
    has_all_corners: bool,
}

impl<'a> DirectedSearch<'a> {
    fn new((from, own): (&'a TriMesh, &FaceTree), target: &'a TargetSurface<'a>, bounds: &DistanceBounds) -> Self {
        // Along the curve of the tree, where neighbours are near the same faces.
        let mut is_listed = vec![false; from.positions().len()];
        let mut faces = measured_faces(from, own.order());
        let along_curve = faces.iter().flat_map(|&face| from.faces()[face as usize]);
        let vertices: Vec<u32> =
            along_curve.filter(|&v| !std::mem::replace(&mut is_listed[v as usize], true)).collect();
        let measured = target.vertex_corners(from, &vertices, bounds);
        let farthest_vertex = measured.iter().map(|corner| corner.distance).fold(0.0, f64::max);
        let has_all_corners = measured.len() == vertices.len();
        faces.sort_unstable();
        let mut corners = vec![PolygonCorner::default(); is_listed.len()];
        vertices.iter().zip(measured).for_each(|(&v, corner)| corners[v as usize] = corner);
        Self { from, faces, target, corners, farthest_vertex, has_all_corners }
    }

    fn face_corners(&self, face: &[u32; 3]) -> [PolygonCorner; 3] {
        face.map(|v| self.corners[v as usize])
    }

    fn search(&self, bounds: &mut DistanceBounds) {
        if bounds.is_too_far() {
            bounds.upper = f64::INFINITY;
            return;
        }
        let corners_of = |face: u32| self.face_corners(&self.from.faces()[face as usize]);
        let is_tight_enough = |upper| bounds.is_tight_enough(upper);
        let upper = |i: usize| {
            let face = self.faces[i];
            (face, self.target.upper_bound(&corners_of(face), is_tight_enough))
        };
        let uppers = parallel::map(self.faces.len(), LEAST, upper);
        let (allowed, faces): (Vec<_>, Vec<_>) = uppers.into_iter().partition(|&(_, upper)| is_tight_enough(upper));
        bounds.upper = allowed.into_iter().map(|(_, upper)| upper).fold(bounds.upper, f64::max);
        let whole = |(face, upper)| SearchItem { upper, part: FacePart::Face(face), n_cuts: 0 };
        let waiting = faces.into_iter().map(whole).collect();
        tighten_bounds(waiting, &corners_of, self.target, bounds);
        if bounds.is_too_far() {
            bounds.upper = f64::INFINITY;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::metrics::{Surface, quick_distance, surface_distance};

    #[test]
    fn what_has_no_area_and_spans_an_opening_is_not_measured() {
        // A frame, and across its opening two triangles on one line.
        let corners = [[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0], [1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0]];
        let positions: Vec<[f32; 3]> = corners.iter().map(|&[x, y]| [x, y, 0.0]).chain([[1.5, 1.5, 0.0]]).collect();
        let frame = (0..4).flat_map(|i| [[i, (i + 1) % 4, i + 4], [i + 4, (i + 1) % 4, (i + 1) % 4 + 4]]);
        let frame = TriMesh::new(positions.clone(), frame.collect()).unwrap();
        let with_slivers = TriMesh::new(positions, [frame.faces(), &[[4, 6, 8], [4, 8, 6]]].concat()).unwrap();
        let distance = |a: &TriMesh, b: &TriMesh| {
            let quick = quick_distance(a, b, 100, 0).unwrap().max;
            quick.max(certified_distance(a, b, &DistanceTolerance::default()).unwrap().upper)
        };
        assert!(distance(&with_slivers, &frame).max(distance(&frame, &with_slivers)) < 1e-12);
        // Without any area, all counts.
        let line = |x: f32| TriMesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [x, 0.0, 0.0]], vec![[0, 1, 2]]).unwrap();
        assert!(distance(&line(3.0), &line(2.0)) >= 1.0);
    }

    #[test]
    fn samples_never_exceed_the_upper_bound() {
        let pairs = [
            (shapes::bolt(32), shapes::bolt(9)),
            (shapes::torus(64, 32, 1.0, 0.25), shapes::torus(20, 9, 1.0, 0.25)),
            (shapes::wavy_sphere(4, 8.0), shapes::icosphere(2)),
            (shapes::cuboid([1.0; 3], 7), shapes::cuboid([1.0, 1.0, 1.2], 3)),
        ];
        for (a, b) in pairs {
            let certified = certified_distance(&a, &b, &DistanceTolerance::default()).unwrap();
            let sampled =
                surface_distance(&Surface::new(&a, 30_000, 0), &Surface::new(&b, 30_000, 0)).unwrap().both.max;
            assert!(sampled <= certified.upper && certified.upper <= 1.01 * certified.lower, "{certified:?} {sampled}");
            assert!(certified.lower < 1.1 * sampled);
        }
    }

    #[test]
    fn a_known_distance_is_found_between_the_corners() {
        // A square without a centre vertex, and one with its centre pushed up.
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
            let certified = certified_distance(a, b, &DistanceTolerance::default()).unwrap();
            assert!((1.99..2.0001).contains(&certified.lower) && certified.upper < 2.05, "{certified:?}");
        }
    }

    #[test]
    fn equal_meshes_are_at_no_distance() {
        let mesh = shapes::cuboid([1.0; 3], 6);
        let certified = certified_distance(&mesh, &mesh, &DistanceTolerance::default()).unwrap();
        assert!(certified.lower < 1e-9 && certified.upper < 1e-6, "{certified:?}");
        assert!(certified_distance(&mesh, &TriMesh::default(), &DistanceTolerance::default()).is_none());
    }

    #[test]
    fn a_search_that_costs_too_much_says_less_and_nothing_false() {
        let (a, b) = (shapes::wavy_sphere(6, 8.0), shapes::icosphere(3));
        let exact = certified_distance(&a, &b, &DistanceTolerance::default()).unwrap();
        let tree = FaceTree::new(b.positions(), b.faces());
        let bounded = |most| {
            let target = TargetSurface::new(&b, &tree, most);
            let mut bounds = DistanceBounds { lower: 0.0, upper: 0.0, tolerance: DistanceTolerance::default() };
            let own = FaceTree::new(a.positions(), a.faces());
            let direction = DirectedSearch::new((&a, &own), &target, &bounds);
            bounds.raise_lower(direction.farthest_vertex);
            direction.has_all_corners.then(|| direction.search(&mut bounds));
            (direction.has_all_corners, bounds.lower, bounds.upper)
        };
        let (is_known, lower, _) = bounded(10);
        assert!(!is_known && lower > 0.0 && lower <= exact.upper);
        assert!(farthest_apart(&a, &b) >= exact.lower);
        // Enough for the vertices, but not for the faces.
        let (is_known, lower, upper) = bounded(2_000_000);
        assert!(is_known && lower <= exact.upper && upper >= exact.lower, "{lower} {upper} {exact:?}");
        let largest = largest_distance_from_faces([&a, &b], &[0, 1, 2], &tree, [0.0, 0.01], 1);
        assert!(largest <= exact.upper);
    }

    #[test]
    fn a_limit_ends_the_search_early() {
        let (a, b) = (shapes::wavy_sphere(5, 8.0), shapes::icosphere(2));
        let exact = certified_distance(&a, &b, &DistanceTolerance::default()).unwrap();
        let within = DistanceTolerance {
            enough: 2.0 * exact.upper,
            too_much: 2.0 * exact.upper,
            ..DistanceTolerance::default()
        };
        assert!(certified_distance(&a, &b, &within).unwrap().upper <= 2.0 * exact.upper + 1e-6);
        let beyond = DistanceTolerance {
            enough: 0.5 * exact.lower,
            too_much: 0.5 * exact.lower,
            ..DistanceTolerance::default()
        };
        assert_eq!(certified_distance(&a, &b, &beyond).unwrap().upper, f64::INFINITY);
        // A few vertices end the search, but not those without faces.
        let trees = [&a, &b].map(|mesh| FaceTree::new(mesh.positions(), mesh.faces()));
        let looks = |tolerance: &DistanceTolerance| {
            certified_distance_by_trees([&a, &b], [&trees[0], &trees[1]], (tolerance, 0.0), u64::MAX).1
        };
        assert!(looks(&beyond) < looks(&within) / 3, "{} {}", looks(&beyond), looks(&within));
        let mut positions = b.positions().to_vec();
        positions.insert(0, [9.0; 3]);
        let faces = b.faces().iter().map(|face| face.map(|v| v + 1)).collect();
        let with_stray = TriMesh::new(positions, faces).unwrap();
        assert!(certified_distance(&a, &with_stray, &within).unwrap().upper <= 2.0 * exact.upper + 1e-6);
    }
}
