//! Bounds of the distance from a triangle to a nearby surface, by overlaying the surface's faces.
//!
//! The triangle is cut along planes through the edges of the surface, and each piece is assigned to one face. The
//! distance to a triangle is convex, so over a piece it is largest at a corner: any assignment gives a proved bound, and a
//! good one a sharp bound.

use glam::DVec3;

use crate::geometry::nearest_on_triangle::nearest_weights_f64;
use crate::geometry::triangle::area_normal_f64;
use crate::mesh::TriMesh;
use crate::mesh::half_edges::{NO_TWIN, twins};
use crate::spatial::{Hit, NearestOnTriangles};

/// Most corners of a piece; larger ones are not cut.
const MOST_CORNERS: usize = 12;
/// Most pieces of a triangle that are cut.
const MOST_CUTS: usize = 96;
/// Most faces that a piece passes; then it starts again from the face closest to it, at most as often as this.
// Around vertices of strongly bent surfaces, the planes leave gaps, in which pieces would turn for ever.
const MOST_STEPS: u8 = 8;
const MOST_STARTS: u8 = 3;
/// Distances of pieces that are not cut, over the largest one of a centroid.
const ENOUGH: f64 = 0.4;
/// Bounds of triangles that are covered again, more sharply, over the largest distance of a centroid.
// Of a thousand triangles of a smooth surface, three or four have walked to a wrong face.
const OUTLIER: f64 = 1.5;
/// Distance that need not be sharper, as a share of the largest coordinate.
const FLOOR: f64 = 1e-7;
/// Bound over the distance of a point at which a piece is not halved further.
const SHARP: f64 = 1.1;
const MOST_HALVINGS: u32 = 8;
/// Distance beyond a plane that does not count, as a share of the edge's length.
const TOLERANCE: f64 = 1e-7;

/// Part of a face of one surface over a face of another.
pub struct CoveredPiece {
    pub face: u32,
    pub over: u32,
    /// Bound of the distance of the piece's points to the other face.
    pub distance: f64,
}

/// A surface with the neighbours of its faces.
pub struct OverlaySurface {
    triangles: Vec<[DVec3; 3]>,
    twins: Vec<u32>,
    /// Cutting plane of each half-edge.
    planes: Vec<EdgePlane>,
    tree: NearestOnTriangles,
}

#[derive(Clone, Copy)]
struct EdgePlane {
    /// Unit normal, towards the half-edge's own face.
    normal: DVec3,
    offset: f64,
    slack: f64,
}

#[derive(Clone, Copy)]
struct Piece {
    points: [DVec3; MOST_CORNERS],
    n: usize,
    /// Face that the piece has reached, and the half-edge of that face through which it came.
    face: u32,
    entry: u32,
    n_steps: u8,
    n_starts: u8,
}

impl OverlaySurface {
    pub fn new(mesh: &TriMesh) -> Self {
        let point = |v: u32| DVec3::from(mesh.positions()[v as usize].map(f64::from));
        let triangles: Vec<[DVec3; 3]> = mesh.faces().iter().map(|face| face.map(point)).collect();
        let twins = twins(mesh.positions().len(), mesh.faces());
        let normals: Vec<DVec3> =
            triangles.iter().map(|&corners| area_normal_f64(corners).normalize_or_zero()).collect();
        let plane = |(half_edge, &twin): (usize, &u32)| {
            let (face, corner) = (half_edge / 3, half_edge % 3);
            let [a, b] = [corner, (corner + 1) % 3].map(|k| triangles[face][k]);
            // Both sides of an edge are cut by the plane through it along the mean normal.
            let other = if twin == NO_TWIN { DVec3::ZERO } else { normals[twin as usize / 3] };
            let normal = (normals[face] + other).cross(b - a).normalize_or_zero();
            EdgePlane { normal, offset: normal.dot(a), slack: TOLERANCE * a.distance(b) }
        };
        let planes = twins.iter().enumerate().map(plane).collect();
        let single = |corners: &[DVec3; 3]| corners.map(|p| p.as_vec3().to_array());
        let tree = NearestOnTriangles::new(&triangles.iter().map(single).collect::<Vec<_>>());
        Self { triangles, twins, planes, tree }
    }

    /// Returns the point of the surface closest to a point.
    pub fn nearest(&self, p: DVec3) -> Option<Hit> {
        self.tree.nearest(p)
    }

    pub fn triangles(&self) -> &[[DVec3; 3]] {
        &self.triangles
    }

    /// Covers this surface by pieces, each with a face of the other surface and a bound of the distance to it.
    pub fn cover_by(&self, other: &Self) -> Vec<CoveredPiece> {
        let hits: Vec<Option<Hit>> = self.triangles.iter().map(|corners| other.nearest(centroid(corners))).collect();
        let least = hits.iter().flatten().map(|hit| hit.distance2).fold(0.0, f64::max).sqrt();
        let floor = FLOOR * self.reach();
        let (mut pieces, mut pending) = (Vec::with_capacity(4 * hits.len()), Vec::new());
        for ((face, &triangle), hit) in (0..).zip(&self.triangles).zip(&hits) {
            let Some(start) = hit.map(|hit| hit.triangle) else { continue };
            let (begin, mut bound) = (pieces.len(), 0.0f64);
            other.cover((triangle, start), (ENOUGH * least).max(floor), &mut pending, |over, distance| {
                bound = bound.max(distance);
                pieces.push(CoveredPiece { face, over, distance });
            });
            let usual = (OUTLIER * least).max(floor);
            if bound > usual {
                pieces.truncate(begin);
                let visit = |over, distance| pieces.push(CoveredPiece { face, over, distance });
                other.cover_by_halving(triangle, usual, visit);
            }
        }
        pieces
    }

    /// Returns the largest coordinate.
    fn reach(&self) -> f64 {
        self.triangles.as_flattened().iter().fold(0.0, |most, p| most.max(p.abs().max_element()))
    }

    /// Covers a triangle by faces, the first of which is `start`; pieces within `enough` of a face are not cut.
    fn cover(
        &self,
        (triangle, start): ([DVec3; 3], u32),
        enough: f64,
        pending: &mut Vec<Piece>,
        mut visit: impl FnMut(u32, f64),
    ) {
        let mut points = [DVec3::ZERO; MOST_CORNERS];
        points[..3].copy_from_slice(&triangle);
        pending.push(Piece { points, n: 3, face: start, entry: NO_TWIN, n_steps: 0, n_starts: 0 });
        let mut n_cuts = 0;
        while let Some(piece) = pending.pop() {
            let piece = if piece.n_steps > MOST_STEPS { self.start_again(piece) } else { piece };
            let distance = self.distance(&piece.points[..piece.n], piece.face);
            n_cuts += 1;
            if distance <= enough || n_cuts > MOST_CUTS || piece.n_starts >= MOST_STARTS {
                visit(piece.face, distance);
            } else if let Some(inside) = self.cut(piece, pending) {
                visit(inside.face, self.distance(&inside.points[..inside.n], inside.face));
            }
        }
    }

    /// Covers a triangle by halving it until bounds are sharp, or at most `enough`.
    fn cover_by_halving(&self, triangle: [DVec3; 3], enough: f64, mut visit: impl FnMut(u32, f64)) {
        let mut pending = vec![(triangle, 0)];
        while let Some((triangle, n_cuts)) = pending.pop() {
            let hits = [triangle[0], triangle[1], triangle[2], centroid(&triangle)].map(|p| self.nearest(p));
            let least = hits.iter().flatten().map(|hit| hit.distance2).fold(0.0, f64::max).sqrt();
            let bounds = hits.iter().flatten().map(|hit| (self.distance(&triangle, hit.triangle), hit.triangle));
            let Some((bound, face)) = bounds.min_by(|x, y| x.0.total_cmp(&y.0)) else { return };
            if bound <= enough.max(SHARP * least) || n_cuts == MOST_HALVINGS {
                visit(face, bound);
                continue;
            }
            let [a, b, c] = rotate_longest_first(triangle);
            let middle = 0.5 * (a + b);
            pending.extend([([a, middle, c], n_cuts + 1), ([middle, b, c], n_cuts + 1)]);
        }
    }

    /// Cuts off all parts beyond the edges of a piece's face; returns the rest.
    fn cut(&self, mut piece: Piece, pending: &mut Vec<Piece>) -> Option<Piece> {
        for half_edge in 3 * piece.face..3 * piece.face + 3 {
            if half_edge == piece.entry || piece.n == MOST_CORNERS {
                continue;
            }
            let (inside, outside) = piece.split(&self.planes[half_edge as usize]);
            if outside.n > 0 {
                let twin = self.twins[half_edge as usize];
                pending.push(match twin {
                    // Beyond the boundary: the rest of the surface may turn back there.
                    NO_TWIN => Piece { n_steps: MOST_STEPS + 1, ..outside },
                    twin => Piece { face: twin / 3, entry: twin, n_steps: piece.n_steps + 1, ..outside },
                });
            }
            if inside.n == 0 {
                return None;
            }
            piece = inside;
        }
        Some(piece)
    }

    fn start_again(&self, piece: Piece) -> Piece {
        let middle = piece.points[..piece.n].iter().sum::<DVec3>() / piece.n as f64;
        let face = self.nearest(middle).map_or(piece.face, |hit| hit.triangle);
        Piece { face, entry: NO_TWIN, n_steps: 0, n_starts: piece.n_starts + 1, ..piece }
    }

    /// Returns the largest distance of a polygon's corners, and so of all its points, to a face.
    fn distance(&self, polygon: &[DVec3], face: u32) -> f64 {
        let corners = self.triangles[face as usize];
        let distance2 = |&p: &DVec3| {
            let [u, v, w] = nearest_weights_f64(p, corners);
            p.distance_squared(u * corners[0] + v * corners[1] + w * corners[2])
        };
        polygon.iter().map(distance2).fold(0.0, f64::max).sqrt()
    }
}

fn rotate_longest_first([a, b, c]: [DVec3; 3]) -> [DVec3; 3] {
    let [ab, bc, ca] = [a.distance_squared(b), b.distance_squared(c), c.distance_squared(a)];
    if ab >= bc.max(ca) {
        [a, b, c]
    } else if bc >= ca {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

pub fn centroid([a, b, c]: &[DVec3; 3]) -> DVec3 {
    (a + b + c) / 3.0
}

impl Piece {
    /// Splits the polygon by a plane; parts without area on one side are empty.
    fn split(&self, plane: &EdgePlane) -> (Self, Self) {
        let side = |p: DVec3| plane.normal.dot(p) - plane.offset;
        let sides: [f64; MOST_CORNERS] = std::array::from_fn(|i| if i < self.n { side(self.points[i]) } else { 0.0 });
        let sides = &sides[..self.n];
        let empty = Self { n: 0, ..*self };
        if sides.iter().all(|side| *side >= -plane.slack) {
            return (*self, empty);
        }
        if sides.iter().all(|side| *side <= 0.0) {
            return (empty, *self);
        }
        // Rounding may have bent a thin piece, which is then left whole: two crossings add one corner to each part.
        let n_crossings = (0..self.n).filter(|&i| sides[i] * sides[(i + 1) % self.n] < 0.0).count();
        if n_crossings > 2 {
            return (*self, empty);
        }
        let (mut inside, mut outside) = (empty, empty);
        for (i, (&p, &side)) in self.points.iter().zip(sides).enumerate() {
            let j = (i + 1) % self.n;
            if side >= 0.0 {
                inside.push(p);
            }
            if side <= 0.0 {
                outside.push(p);
            }
            if side * sides[j] < 0.0 {
                let middle = p.lerp(self.points[j], side / (side - sides[j]));
                inside.push(middle);
                outside.push(middle);
            }
        }
        (inside, outside)
    }

    fn push(&mut self, p: DVec3) {
        // Full polygons are not cut, so there is room.
        self.points[self.n] = p;
        self.n += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::metrics::{DistanceTolerance, certified_distance};

    fn largest(from: &TriMesh, to: &TriMesh) -> f64 {
        let pieces = OverlaySurface::new(from).cover_by(&OverlaySurface::new(to));
        pieces.iter().map(|piece| piece.distance).fold(0.0, f64::max)
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
    fn pieces_cover_the_triangle() {
        let target = OverlaySurface::new(&shapes::icosphere(3));
        let triangle = shapes::icosphere(1).faces()[5].map(|v| shapes::icosphere(1).positions()[v as usize]);
        let triangle = triangle.map(|p| DVec3::from(p.map(f64::from)));
        let mut faces = Vec::new();
        let start = target.nearest(centroid(&triangle)).unwrap().triangle;
        target.cover((triangle, start), 0.0, &mut Vec::new(), |face, _| faces.push(face));
        // A face of the coarse sphere lies over sixteen of the fine one, and touches their neighbours.
        faces.sort_unstable();
        faces.dedup();
        assert!((16..=46).contains(&faces.len()), "{}", faces.len());
    }
}
