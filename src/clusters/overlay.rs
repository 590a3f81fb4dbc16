//! Bounds of the distance from the triangles of a surface to a nearby surface, by overlaying their faces.

use std::cell::OnceCell;

use glam::DVec3;

use crate::geometry::triangle::area_normal_f64;
use crate::mesh::half_edges::NO_TWIN;

use super::cut_pieces::Piece;
use super::footprint::{Footprint, passes_inside};
use super::overlay_surface::{OverlaySurface, centroid, largest_distance};

/// Distances that are not made sharper, over the largest one of a centroid.
const ENOUGH: f64 = 0.4;
/// Bounds of triangles that are covered again, more sharply, over the largest distance of a centroid.
// Of a thousand triangles of a smooth surface, three or four have walked to a wrong face.
const OUTLIER: f64 = 1.5;
/// Height over a face, over the distance to the closest one, from which on the face is of another component.
// With 1.5, errors of a wavy sphere are a little larger; heights over wrong components are tens of times the distance.
const FAR: f64 = 4.0;
/// Distance that need not be sharper, as a share of the largest coordinate.
const FLOOR: f64 = 1e-7;
/// Least cosine between the normal of a triangle and that of the face over its centroid.
const LEAST_COSINE: f64 = 0.2;
/// Least cosine between the direction of sight and the normals of all faces over a triangle.
// Beyond a crease of nearly a right angle, heights are still those of points on both surfaces.
const LEAST_COSINE_OVER: f64 = 0.02;
/// Most searches through all centroids for a start; more are a reason to build the tree.
const FEW_QUERIES: usize = 16;
/// Most faces between the hint and the face over a centroid.
const MOST_STEPS: usize = 8;

/// Most halvings of a surface's triangles, over their number. Each of a fan of needles would take 255.
const MOST_HALVINGS: usize = 4;

/// Part of a face of one surface near a face of another.
pub struct CoveredPiece {
    pub face: u32,
    pub over: u32,
    /// Bound of the distance of the piece's points to the other face.
    pub distance: f64,
}

/// Pieces that cover a surface.
pub struct Cover {
    pub pieces: Vec<CoveredPiece>,
    /// Face of the other surface at the centroid of each face, n_faces.
    pub at_centroids: Vec<Footing>,
}

/// Face of one surface at the centroid of a face of another.
#[derive(Clone, Copy)]
pub struct Footing {
    pub face: u32,
    /// True if the centroid lies over the face as seen along the normal; otherwise the face is the closest one.
    is_below: bool,
}

/// State while triangles are covered one after the other.
pub struct Covering<'a> {
    other: &'a OverlaySurface,
    /// Bound that need not be sharper.
    pub enough: f64,
    /// Bound above which a triangle is covered again by a sharper method.
    pub usual: f64,
    halvings_left: usize,
    queue: FaceQueue,
    pending: Vec<Piece>,
    /// Faces over the triangle that was covered last, with bounds.
    pub parts: Vec<(u32, f64)>,
    /// Faces and bounds by the method that was sharpest so far.
    sharpest: Vec<(u32, f64)>,
}

/// Faces that are still to be visited, and those that have been.
struct FaceQueue {
    pending: Vec<u32>,
    /// Round in which each face was last found.
    found: Vec<u32>,
    round: u32,
}

impl OverlaySurface {
    /// Covers this surface by pieces, each with a face of the other surface and a bound of the distance to it.
    ///
    /// `enough` receives a face and the largest distance of a centroid, and returns a distance that need not be sharper.
    pub fn cover_by(&self, other: &Self, enough: impl Fn(u32, f64) -> f64) -> Cover {
        let (at_centroids, least) = self.find_centroids(other);
        let floor = FLOOR * self.reach();
        let mut covering = Covering::new(other, self.triangles.len());
        (covering.enough, covering.usual) = ((ENOUGH * least).max(floor), (OUTLIER * least).max(floor));
        let mut pieces = Vec::with_capacity(4 * self.triangles.len());
        let usual_enough = covering.enough;
        for (face, start) in (0..).zip(&at_centroids) {
            covering.enough = usual_enough.max(enough(face, least));
            covering.cover((self.triangles[face as usize], self.normals[face as usize]), *start);
            let piece = |&(over, distance): &(u32, f64)| CoveredPiece { face, over, distance };
            pieces.extend(covering.parts.iter().map(piece));
        }
        Cover { pieces, at_centroids }
    }

    /// Finds the face of the other surface at each centroid, from neighbour to neighbour; also returns the largest distance.
    fn find_centroids(&self, other: &Self) -> (Vec<Footing>, f64) {
        let mut found: Vec<Option<Footing>> = vec![None; self.triangles.len()];
        let (mut pending, mut heights) = (Vec::new(), vec![0.0; self.triangles.len()]);
        let mut n_first = 0;
        for first in 0..found.len() {
            if found[first].is_some() {
                continue;
            }
            let (middle, normal) = (centroid(&self.triangles[first]), self.normals[first]);
            // A few queries are no reason to build the tree.
            let by_centroid = || other.face_below(other.face_with_nearest_centroid(middle), middle, normal);
            let below = if n_first < FEW_QUERIES { by_centroid() } else { None };
            n_first += 1;
            pending.push((first, below.unwrap_or_else(|| other.footing_near(middle, normal))));
            while let Some((face, (footing, distance))) = pending.pop() {
                if found[face].is_some() {
                    continue;
                }
                (heights[face], found[face]) = (distance, Some(footing));
                let twins = self.twins[3 * face..3 * face + 3].iter().filter(|twin| **twin != NO_TWIN);
                for next in twins.map(|twin| *twin as usize / 3).filter(|&next| found[next].is_none()) {
                    let below = other.face_below(footing.face, centroid(&self.triangles[next]), self.normals[next]);
                    pending.extend(below.map(|below| (next, below)));
                }
            }
        }
        let mut found: Vec<Footing> = found.into_iter().flatten().collect();
        let largest = self.correct_largest(other, &mut found, heights);
        (found, largest)
    }

    /// Replaces footings that are far from the closest faces, the highest first, until one is not; returns its height.
    ///
    /// Faces near another component are above that one in part, however far it is.
    fn correct_largest(&self, other: &Self, found: &mut [Footing], mut heights: Vec<f64>) -> f64 {
        let mut faces: Vec<u32> = (0..heights.len() as u32).collect();
        faces.sort_by(|&x, &y| heights[y as usize].total_cmp(&heights[x as usize]));
        let (mut largest, floor) = (0.0f64, FLOOR * self.reach());
        for face in faces.into_iter().map(|face| face as usize) {
            // The others are lower.
            if heights[face] <= largest.max(floor) {
                break;
            }
            let (middle, normal) = (centroid(&self.triangles[face]), self.normals[face]);
            let (nearest, distance) = other.nearest(middle);
            if heights[face] > FAR * distance {
                let below = other.face_below(nearest, middle, normal).filter(|(_, height)| *height <= FAR * distance);
                (found[face], heights[face]) = below.unwrap_or((Footing { face: nearest, is_below: false }, distance));
            }
            largest = largest.max(heights[face]);
        }
        largest
    }

    fn face_with_nearest_centroid(&self, p: DVec3) -> u32 {
        let distances = (0u32..).zip(&self.triangles).map(|(face, it)| (centroid(it).distance_squared(p), face));
        distances.min_by(|x, y| x.0.total_cmp(&y.0)).map_or(0, |(_, face)| face)
    }

    /// Returns the face below the centroid of a triangle near the face `hint`, or else near the closest one.
    pub fn footing_of(&self, triangle: &[DVec3; 3], normal: DVec3, hint: u32) -> Footing {
        let middle = centroid(triangle);
        self.face_below(hint, middle, normal).unwrap_or_else(|| self.footing_near(middle, normal)).0
    }

    /// Returns the face below the centroid of a triangle near the face `hint`.
    pub fn footing_below(&self, triangle: &[DVec3; 3], normal: DVec3, hint: u32) -> Option<Footing> {
        self.face_below(hint, centroid(triangle), normal).map(|found| found.0)
    }

    /// Returns the face below a point and near the closest face, or else the closest one; and its distance.
    fn footing_near(&self, p: DVec3, normal: DVec3) -> (Footing, f64) {
        let (face, distance) = self.nearest(p);
        self.face_below(face, p, normal).unwrap_or((Footing { face, is_below: false }, distance))
    }

    /// Returns the face below a point, as seen along `normal`, in a few steps from `face`; and the height.
    fn face_below(&self, mut face: u32, p: DVec3, normal: DVec3) -> Option<(Footing, f64)> {
        for _ in 0..MOST_STEPS {
            let cosine = self.normals[face as usize].dot(normal);
            if cosine < LEAST_COSINE {
                return None;
            }
            let corners = self.triangles[face as usize];
            let sides = (0..3).map(|k| {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                (k, (b - a).cross(p - a).dot(normal))
            });
            let (side, least) = sides.min_by(|x, y| x.1.total_cmp(&y.1))?;
            if least >= 0.0 {
                let height = self.normals[face as usize].dot(p - corners[0]) / cosine;
                return Some((Footing { face, is_below: true }, height.abs()));
            }
            face = match self.twins[3 * face as usize + side] {
                NO_TWIN => return None,
                twin => twin / 3,
            };
        }
        None
    }

    /// Visits the faces over a triangle, from the one over its centroid, with bounds of their heights.
    ///
    /// Bounds of at most `enough` are not sharp. Returns false if the faces may leave a part of the triangle open.
    fn cover(
        &self,
        start: u32,
        triangle: &Footprint,
        enough: f64,
        queue: &mut FaceQueue,
        mut visit: impl FnMut(u32, f64),
    ) -> bool {
        queue.begin(start);
        while let Some(face) = queue.pending.pop() {
            if self.normals[face as usize].dot(triangle.direction) < LEAST_COSINE_OVER {
                return false;
            }
            let corners = self.triangles[face as usize].map(|p| triangle.coordinates(p));
            visit(face, triangle.height(&corners, enough));
            for side in 0..3 {
                if passes_inside(corners[side], corners[(side + 1) % 3]) {
                    match self.twins[3 * face as usize + side] {
                        NO_TWIN => return false,
                        twin => queue.add(twin / 3),
                    }
                }
            }
        }
        true
    }
}

impl<'a> Covering<'a> {
    /// Returns the state before the first of `n` triangles.
    pub fn new(other: &'a OverlaySurface, n: usize) -> Self {
        Self {
            other,
            enough: 0.0,
            usual: 0.0,
            halvings_left: MOST_HALVINGS * n,
            queue: FaceQueue { pending: Vec::new(), found: vec![0; other.triangles.len()], round: 0 },
            pending: Vec::new(),
            parts: Vec::new(),
            sharpest: Vec::new(),
        }
    }

    /// Covers a triangle by the fastest method with a usual bound, or else by the sharpest one.
    ///
    /// `parts` has the faces and their bounds.
    pub fn cover(&mut self, (triangle, normal): ([DVec3; 3], DVec3), start: Footing) {
        let (other, usual) = (self.other, self.usual.max(self.enough));
        self.sharpest.clear();
        let own = start.is_below.then_some((normal, start));
        // The normal of a needle is that of its rounding, so the one of the face near it is tried, too.
        let direction = other.normals[start.face as usize];
        let of_face = || other.footing_below(&triangle, direction, start.face).map(|start| (direction, start));
        let sampled = OnceCell::new();
        for method in 0..4 {
            let is_covered = match method {
                0 => own.is_some_and(|along| self.cover_along(along, &triangle)),
                1 => of_face().is_some_and(|along| self.cover_along(along, &triangle)),
                2 => {
                    self.cover_by_cutting(&triangle, start);
                    true
                }
                _ => {
                    self.cover_by_halving(&triangle, usual);
                    true
                }
            };
            let bound = largest_distance(&self.parts);
            let largest_sample = || *sampled.get_or_init(|| largest_distance(&other.nearest_samples(&triangle)));
            if is_covered && (bound <= usual || bound <= OUTLIER * largest_sample()) {
                return;
            }
            if is_covered && (self.sharpest.is_empty() || bound < largest_distance(&self.sharpest)) {
                std::mem::swap(&mut self.sharpest, &mut self.parts);
            }
        }
        std::mem::swap(&mut self.sharpest, &mut self.parts);
    }

    fn cover_by_cutting(&mut self, triangle: &[DVec3; 3], start: Footing) {
        let parts = &mut self.parts;
        parts.clear();
        let visit = |over, distance| parts.push((over, distance));
        self.other.cover_by_cutting((*triangle, start.face), self.enough, &mut self.pending, visit);
    }

    fn cover_by_halving(&mut self, triangle: &[DVec3; 3], usual: f64) {
        let parts = &mut self.parts;
        parts.clear();
        let visit = |over, distance| parts.push((over, distance));
        self.other.cover_by_halving(*triangle, usual, &mut self.halvings_left, visit);
    }

    /// Covers a triangle by the faces over it as seen along `direction`; false if they may leave a part of it open.
    fn cover_along(&mut self, (direction, start): (DVec3, Footing), &[a, b, c]: &[DVec3; 3]) -> bool {
        let parts = &mut self.parts;
        parts.clear();
        let is_turned = area_normal_f64([a, b, c]).dot(direction) < 0.0;
        let triangle = if is_turned { [a, c, b] } else { [a, b, c] };
        let Some(footprint) = Footprint::new(triangle, direction) else { return false };
        let visit = |over, distance| parts.push((over, distance));
        self.other.cover(start.face, &footprint, self.enough, &mut self.queue, visit)
    }
}

impl FaceQueue {
    fn begin(&mut self, start: u32) {
        self.round += 1;
        self.pending.clear();
        self.add(start);
    }

    fn add(&mut self, face: u32) {
        if self.found[face as usize] != self.round {
            self.found[face as usize] = self.round;
            self.pending.push(face);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{TriMesh, shapes};
    use crate::metrics::{DistanceTolerance, certified_distance};

    fn largest(from: &TriMesh, to: &TriMesh) -> f64 {
        let cover = OverlaySurface::from_mesh(from).cover_by(&OverlaySurface::from_mesh(to), |_, _| 0.0);
        cover.pieces.iter().map(|piece| piece.distance).fold(0.0, f64::max)
    }

    #[test]
    fn bounds_are_proved_and_sharp_between_near_surfaces() {
        let pairs = [
            (shapes::icosphere(4), shapes::icosphere(3)),
            (shapes::torus(64, 32, 1.0, 0.25), shapes::torus(40, 21, 1.0, 0.25)),
            (shapes::wavy_sphere(4, 8.0), shapes::wavy_sphere(3, 8.0)),
            (shapes::cuboid([1.0; 3], 7), shapes::cuboid([1.0, 1.0, 1.1], 3)),
        ];
        for (a, b) in pairs {
            let bound = largest(&a, &b).max(largest(&b, &a));
            let certified = certified_distance(&a, &b, &DistanceTolerance::default()).unwrap();
            assert!(bound >= certified.lower && bound < 1.5 * certified.upper, "{bound} {certified:?}");
        }
    }

    #[test]
    fn bounds_are_sharp_under_another_component() {
        // Under a ball, the ball's centroids are nearer than those of the few triangles of a floor.
        let scene = |n_squares: u32, ball: u32, height: f32| {
            let (floor, ball) = (shapes::grid(n_squares, n_squares), shapes::icosphere(ball));
            let of_floor = floor.positions().iter().map(|p| [30.0 * p[0], 30.0 * p[1], height]);
            let of_ball = ball.positions().iter().map(|p| [9.0 + p[0], 9.0 + p[1], 2.5 + p[2]]);
            let n = floor.positions().len() as u32;
            let of_ball_faces = ball.faces().iter().map(|face| face.map(|v| v + n));
            let faces = floor.faces().iter().copied().chain(of_ball_faces).collect();
            TriMesh::new(of_floor.chain(of_ball).collect(), faces).unwrap()
        };
        let (fine, coarse) = (scene(32, 3, 0.0), scene(3, 2, 0.01));
        let bound = largest(&fine, &coarse).max(largest(&coarse, &fine));
        let certified = certified_distance(&fine, &coarse, &DistanceTolerance::default()).unwrap();
        assert!(bound >= certified.lower && bound < 1.5 * certified.upper, "{bound} {certified:?}");
    }

    #[test]
    fn faces_over_a_triangle_are_found() {
        let (coarse, fine) =
            (OverlaySurface::from_mesh(&shapes::icosphere(1)), OverlaySurface::from_mesh(&shapes::icosphere(3)));
        let cover = coarse.cover_by(&fine, |_, _| 0.0);
        for face in 0..coarse.triangles.len() as u32 {
            let mut over: Vec<u32> = cover.pieces.iter().filter(|it| it.face == face).map(|it| it.over).collect();
            over.sort_unstable();
            over.dedup();
            // A face of the coarse sphere lies over sixteen of the fine one, and touches their neighbours.
            assert!((16..=46).contains(&over.len()), "{}", over.len());
        }
    }

    #[test]
    fn a_triangle_beyond_the_boundary_is_far() {
        let square = shapes::grid(4, 4);
        let shifted = square.positions().iter().map(|p| [p[0] + 0.3, p[1], p[2]]).collect();
        let shifted = TriMesh::new(shifted, square.faces().to_vec()).unwrap();
        let bound = largest(&shifted, &square);
        assert!((0.299..0.45).contains(&bound), "{bound}");
    }
}
