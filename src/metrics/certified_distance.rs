//! The largest distance between two surfaces with proof: bounds from below and above, by branch and bound.
//!
//! The distance to a triangle is a convex function, so over a triangle T it is largest at a corner. The largest distance of T
//! to a surface is therefore at most `min over its faces F of max over the corners v of T of d(v, F)`; the faces nearest to the
//! corners serve as F. A corner's own distance bounds it from below. Triangles whose bounds are too far apart are cut,
//! in four, those with the largest upper bound first (after Tang, Lee and Kim 2009, "Interactive Hausdorff distance
//! computation for general polygonal models"). What takes longest is flat parts that agree, cut otherwise: their triangles
//! are cut down to the size of what is asked for.

use std::collections::BinaryHeap;

use glam::DVec3;
use rayon::prelude::*;

use crate::geometry::nearest_on_triangle::nearest_weights_f64;
use crate::mesh::TriMesh;
use crate::spatial::FaceTree;

/// Cuts after which the search gives what it has: the bounds are then farther apart than asked.
const MOST_CUTS: usize = 1_000_000;
/// Distances below this share of the diagonal are rounding.
const ROUNDING: f64 = 1e-7;

/// Bounds of the largest distance from either surface to the other, in the mesh's unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CertifiedDistance {
    /// Some point is at least so far from the other surface.
    pub lower: f64,
    /// No point is farther.
    pub upper: f64,
    /// Diagonal of the original's bounding box.
    pub diagonal: f64,
}

/// How sharp the bounds have to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sharpness {
    /// The upper bound may exceed the lower by this share of it.
    pub gap: f64,
    /// Nor need the upper bound be sharper than this distance.
    pub enough: f64,
    /// Once the lower bound exceeds this distance, the search ends with infinity as the upper bound.
    pub too_much: f64,
}

impl Default for Sharpness {
    /// Two percent apart, whatever the distance.
    fn default() -> Self {
        Self { gap: 0.02, enough: 0.0, too_much: f64::INFINITY }
    }
}

/// Bounds the two-sided (Hausdorff) distance; `None` where one of the two has no faces.
///
/// The bounds hold for the coordinates as given, up to 1e-7 of the diagonal.
///
/// ```
/// use neural_mesh::{mesh::shapes, metrics::{Sharpness, certified_distance}};
/// let distance = certified_distance(&shapes::icosphere(4), &shapes::icosphere(1), &Sharpness::default()).unwrap();
/// assert!(distance.lower > 0.05 && distance.upper <= 1.021 * distance.lower);
/// ```
pub fn certified_distance(original: &TriMesh, simplified: &TriMesh, asked: &Sharpness) -> Option<CertifiedDistance> {
    if original.faces().is_empty() || simplified.faces().is_empty() {
        return None;
    }
    let diagonal = original.diagonal();
    let slack = ROUNDING * diagonal;
    let asked = Sharpness { enough: (asked.enough - slack).max(slack), ..*asked };
    let mut bounds = Bounds { lower: 0.0, upper: 0.0, asked };
    // The simplified mesh has fewer faces: it is searched first, and raises the lower bound for the other.
    for [from, to] in [[simplified, original], [original, simplified]] {
        let other = Other { mesh: to, tree: FaceTree::new(to.positions(), to.faces()) };
        search(from, &other, &mut bounds);
    }
    Some(CertifiedDistance { lower: bounds.lower, upper: bounds.upper.max(bounds.lower) + slack, diagonal })
}

/// What is known of the largest distance so far.
struct Bounds {
    lower: f64,
    /// Of all that was put aside.
    upper: f64,
    asked: Sharpness,
}

impl Bounds {
    /// Whether a triangle with this upper bound need not be cut.
    fn allow(&self, upper: f64) -> bool {
        upper <= self.asked.enough.max(self.lower * (1.0 + self.asked.gap))
    }

    fn is_beyond(&self) -> bool {
        self.lower > self.asked.too_much
    }
}

/// The surface that distances are measured to.
struct Other<'a> {
    mesh: &'a TriMesh,
    tree: FaceTree<'a>,
}

/// A corner of a triangle: where, how far from the other surface, and which face of it is nearest.
#[derive(Clone, Copy)]
struct Corner {
    point: DVec3,
    distance: f64,
    nearest: u32,
}

impl Other<'_> {
    fn corner(&self, point: DVec3) -> Corner {
        let (nearest, distance2) = self.tree.nearest(point).unwrap_or((0, f64::INFINITY));
        Corner { point, distance: distance2.sqrt(), nearest }
    }

    /// The upper bound for the triangle with these corners, no sharper than the bounds need.
    fn upper(&self, corners: &[Corner; 3], bounds: &Bounds) -> f64 {
        let over = |face: u32| corners.iter().map(|corner| self.distance(corner, face)).fold(0.0, f64::max);
        let mut upper = farthest_by_the_triangle_inequality(corners);
        let [a, b, c] = corners.map(|corner| corner.nearest);
        for (face, is_new) in [(a, true), (b, b != a), (c, c != a && c != b)] {
            if is_new && !bounds.allow(upper) {
                upper = upper.min(over(face));
            }
        }
        // Where faces meet in a corner, its nearest face is any of them; that of the middle may be nearer to all three.
        if !bounds.allow(upper) {
            upper = upper.min(over(self.corner(middle(corners)).nearest));
        }
        upper
    }

    fn distance(&self, corner: &Corner, face: u32) -> f64 {
        if corner.nearest == face {
            return corner.distance;
        }
        let [a, b, c] = self.mesh.faces()[face as usize].map(|v| point(self.mesh, v));
        let weights = nearest_weights_f64(corner.point, [a, b, c]);
        (a * weights[0] + b * weights[1] + c * weights[2]).distance(corner.point)
    }
}

fn middle(corners: &[Corner; 3]) -> DVec3 {
    corners.iter().map(|corner| corner.point).sum::<DVec3>() / 3.0
}

/// No point of a triangle is farther from a surface than a corner is, plus the way to that corner.
fn farthest_by_the_triangle_inequality(corners: &[Corner; 3]) -> f64 {
    let reach = |i: usize| {
        let way = |j: usize| corners[i].point.distance(corners[j].point);
        corners[i].distance + way((i + 1) % 3).max(way((i + 2) % 3))
    };
    reach(0).min(reach(1)).min(reach(2))
}

fn point(mesh: &TriMesh, v: u32) -> DVec3 {
    DVec3::from(mesh.positions()[v as usize].map(f64::from))
}

/// A triangle that waits to be cut, by its upper bound.
struct Waiting {
    upper: f64,
    corners: [Corner; 3],
}

impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.upper.total_cmp(&other.upper)
    }
}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Waiting {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Waiting {}

/// Tightens the bounds by the distances from one mesh to the other.
fn search(from: &TriMesh, other: &Other, bounds: &mut Bounds) {
    let corners: Vec<Corner> =
        (0..from.positions().len() as u32).into_par_iter().map(|v| other.corner(point(from, v))).collect();
    let used = from.faces().as_flattened().iter().map(|&v| corners[v as usize].distance);
    bounds.lower = used.fold(bounds.lower, f64::max);
    if bounds.is_beyond() {
        bounds.upper = f64::INFINITY;
        return;
    }
    let of_face = |face: &[u32; 3]| {
        let corners = face.map(|v| corners[v as usize]);
        Waiting { upper: other.upper(&corners, bounds), corners }
    };
    let faces: Vec<Waiting> = from.faces().par_iter().map(of_face).filter(|w| !bounds.allow(w.upper)).collect();
    // What was let through lies below what the bounds allow.
    bounds.upper = bounds.upper.max(bounds.asked.enough.max(bounds.lower * (1.0 + bounds.asked.gap)));
    let mut waiting = BinaryHeap::from(faces);
    let mut n_cuts = 0;
    while let Some(next) = waiting.pop() {
        if bounds.allow(next.upper) || n_cuts == MOST_CUTS {
            bounds.upper = bounds.upper.max(next.upper);
            return;
        }
        n_cuts += 1;
        cut(&next.corners, other, bounds, &mut waiting);
        if bounds.is_beyond() {
            bounds.upper = f64::INFINITY;
            return;
        }
    }
}

/// Cuts a triangle in four.
fn cut(corners: &[Corner; 3], other: &Other, bounds: &mut Bounds, waiting: &mut BinaryHeap<Waiting>) {
    let between = |i: usize, j: usize| other.corner((corners[i].point + corners[j].point) * 0.5);
    let [a, b, c] = *corners;
    let [ab, bc, ca] = [between(0, 1), between(1, 2), between(2, 0)];
    bounds.lower = [ab, bc, ca].iter().map(|corner| corner.distance).fold(bounds.lower, f64::max);
    for corners in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
        let upper = other.upper(&corners, bounds);
        if bounds.allow(upper) {
            bounds.upper = bounds.upper.max(upper);
        } else {
            waiting.push(Waiting { upper, corners });
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
            assert!(
                sampled <= certified.upper && certified.upper <= 1.021 * certified.lower,
                "{certified:?} {sampled}"
            );
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
    fn a_limit_ends_the_search_early() {
        let (a, b) = (shapes::wavy_sphere(5, 8.0), shapes::icosphere(2));
        let exact = certified_distance(&a, &b, &Sharpness::default()).unwrap();
        let within = Sharpness { enough: 2.0 * exact.upper, too_much: 2.0 * exact.upper, ..Sharpness::default() };
        assert!(certified_distance(&a, &b, &within).unwrap().upper <= 2.0 * exact.upper + 1e-6);
        let beyond = Sharpness { enough: 0.5 * exact.lower, too_much: 0.5 * exact.lower, ..Sharpness::default() };
        assert_eq!(certified_distance(&a, &b, &beyond).unwrap().upper, f64::INFINITY);
    }
}
