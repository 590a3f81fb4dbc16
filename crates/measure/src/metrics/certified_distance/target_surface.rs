//! The surface that distances are measured to.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;

use super::distance_bounds::DistanceBounds;
use super::polygon::{CutPlane, PolygonCorner, radius_from};
use crate::geometry::nearest_on_triangle::nearest_weights_f64;
use crate::geometry::triangle::{area_normal_f64, corners_f64};
use crate::linalg::{Isa, Work};
use crate::mesh::TriMesh;
use crate::parallel;
use crate::spatial::{FaceTree, SearchCost};

/// Squared length below which the difference of two unit normals has no direction.
const NO_DIRECTION: f64 = 1e-12;
const MAX_BATCH: usize = 2048;
const MIN_VISITS_PER_ROUND: u64 = 1_000_000;
const MIN_BATCH: usize = 16;
/// Vertices that one search after another goes through.
const ROW: usize = 128;
/// Share of the lower bound within which a vertex' closest face need not be known: small faces around it are near, too.
const NEAR_SHARE: f64 = 0.5;

pub(super) struct TargetSurface<'a> {
    mesh: &'a TriMesh,
    tree: &'a FaceTree<'a>,
    n_visits: AtomicU64,
    most_visits: u64,
    with_boxes: bool,
    n_searches: AtomicU64,
}

impl<'a> TargetSurface<'a> {
    pub(super) fn new(mesh: &'a TriMesh, tree: &'a FaceTree<'a>, most_visits: u64) -> Self {
        Self { mesh, tree, n_visits: AtomicU64::new(0), most_visits, with_boxes: true, n_searches: AtomicU64::new(0) }
    }

    pub(super) fn counting_triangles_only(self) -> Self {
        Self { with_boxes: false, ..self }
    }

    pub(super) fn n_visits(&self) -> u64 {
        self.n_visits.load(Ordering::Relaxed)
    }

    pub(super) fn is_exhausted(&self) -> bool {
        self.n_visits() >= self.most_visits
    }

    /// Returns how many items, at most `most` and each with `n_searches` searches, fit the remaining budget.
    pub(super) fn batch_size(&self, most: usize, n_searches: u64) -> usize {
        let each = self.n_visits() / self.n_searches.load(Ordering::Relaxed).max(1);
        let left = self.most_visits.saturating_sub(self.n_visits()).max(MIN_VISITS_PER_ROUND);
        (left / (n_searches * each).max(1)).clamp(MIN_BATCH as u64, most as u64) as usize
    }

    pub(super) fn corner(&self, point: DVec3, guess: Option<u32>) -> PolygonCorner {
        self.corner_near(point, guess, f64::NEG_INFINITY)
    }

    /// Measures a point's distance to the surface, or to any face at a squared distance of at most `enough`.
    pub(super) fn corner_near(&self, point: DVec3, guess: Option<u32>, enough: f64) -> PolygonCorner {
        let found = Isa::best().run(NearSearch { tree: self.tree, point, guess, enough });
        let (face, distance2, looks) = found.unwrap_or((0, f64::INFINITY, SearchCost::default()));
        self.count(1, looks);
        PolygonCorner { point, distance: distance2.sqrt(), face }
    }

    /// Measures a point's distance to `face` if that is at most the lower bound, else as `corner_enough` does.
    pub(super) fn corner_from_face(&self, face: u32, point: DVec3, bounds: &DistanceBounds) -> PolygonCorner {
        let corner = PolygonCorner { point, distance: self.distance_to(face, point), face };
        if corner.distance <= bounds.lower { corner } else { self.corner_enough(point, face, bounds) }
    }

    /// Measures a point's distance exactly, or to any face within a share of the lower bound.
    pub(super) fn corner_enough(&self, point: DVec3, guess: u32, bounds: &DistanceBounds) -> PolygonCorner {
        self.corner_near(point, Some(guess), near_enough(bounds.lower))
    }

    /// Measures vertices of a mesh until one is too far: each exactly, or at most at half of the lower bound.
    pub(super) fn vertex_corners(
        &self,
        from: &TriMesh,
        vertices: &[u32],
        bounds: &DistanceBounds,
    ) -> Vec<PolygonCorner> {
        let mut corners: Vec<PolygonCorner> = Vec::with_capacity(vertices.len());
        let (mut is_too_far, mut lower) = (bounds.is_too_far(), bounds.lower);
        while corners.len() < vertices.len() && !self.is_exhausted() && !is_too_far {
            let first = corners.len();
            let n = if first == 0 { 2 * MIN_BATCH } else { self.batch_size(MAX_BATCH, 1) };
            let row = &vertices[first..vertices.len().min(first + n)];
            let enough = near_enough(lower);
            corners
                .extend(parallel::chunks(row, ROW, |_, row| self.row_corners(from, row, enough)).into_iter().flatten());
            lower = corners[first..].iter().map(|corner| corner.distance).fold(lower, f64::max);
            is_too_far = lower > bounds.tolerance.too_much;
        }
        corners
    }

    fn row_corners(&self, from: &TriMesh, vertices: &[u32], enough: f64) -> Vec<PolygonCorner> {
        let point = |&v: &u32| DVec3::from(from.positions()[v as usize].map(f64::from));
        let points: Vec<DVec3> = vertices.iter().map(point).collect();
        let (found, cost) = self.tree.find_near_in_row(&points, enough);
        self.count(points.len(), cost);
        let corner =
            |(point, (face, distance2)): (DVec3, (u32, f64))| PolygonCorner { point, distance: distance2.sqrt(), face };
        points.into_iter().zip(found).map(corner).collect()
    }

    fn count(&self, n_searches: usize, cost: SearchCost) {
        let n_visits = if self.with_boxes { cost.total() } else { cost.triangles };
        self.n_visits.fetch_add(n_visits.into(), Ordering::Relaxed);
        self.n_searches.fetch_add(n_searches as u64, Ordering::Relaxed);
    }

    /// Returns an upper bound of the distance over a polygon; stops tightening it when `is_tight` accepts it.
    pub(super) fn upper_bound(&self, corners: &[PolygonCorner], is_tight: impl Fn(f64) -> bool) -> f64 {
        let mut upper = f64::INFINITY;
        for (i, corner) in corners.iter().enumerate() {
            upper = upper.min(corner.distance + radius_from(corners, corner));
            let is_new = || corners[..i].iter().all(|before| before.face != corner.face);
            if !is_tight(upper) && is_new() {
                upper = upper.min(self.distance_from_face(corners, corner.face));
            }
            if is_tight(upper) {
                return upper;
            }
        }
        upper
    }

    pub(super) fn distance_from_face(&self, corners: &[PolygonCorner], face: u32) -> f64 {
        corners.iter().map(|corner| self.distance(corner, face)).fold(0.0, f64::max)
    }

    fn distance(&self, corner: &PolygonCorner, face: u32) -> f64 {
        if corner.face == face { corner.distance } else { self.distance_to(face, corner.point) }
    }

    fn distance_to(&self, face: u32, point: DVec3) -> f64 {
        let [a, b, c] = self.triangle(face);
        let weights = nearest_weights_f64(point, [a, b, c]);
        (a * weights[0] + b * weights[1] + c * weights[2]).distance(point)
    }

    pub(super) fn longest_side(&self, face: u32) -> f64 {
        let [a, b, c] = self.triangle(face);
        a.distance(b).max(b.distance(c)).max(c.distance(a))
    }

    pub(super) fn side_planes(&self, face: u32) -> [CutPlane; 3] {
        let [a, b, c] = self.triangle(face);
        let normal = self.normal(face);
        let wall =
            |from: DVec3, to: DVec3| CutPlane { point: from, normal: normal.cross(to - from).normalize_or_zero() };
        [wall(a, b), wall(b, c), wall(c, a)]
    }

    /// Returns the plane of equal distance to `face` and to another face.
    pub(super) fn bisector(&self, corners: &[PolygonCorner], face: u32) -> Option<CutPlane> {
        let gained = |corner: &PolygonCorner| self.distance(corner, face) - corner.distance;
        let apart = corners.iter().filter(|corner| corner.face != face);
        let leaving = apart.max_by(|x, y| gained(x).total_cmp(&gained(y)))?;
        let plane_towards = |face: u32| {
            let (point, normal) = (self.triangle(face)[0], self.normal(face));
            CutPlane { point, normal: if normal.dot(leaving.point - point) < 0.0 { -normal } else { normal } }
        };
        let (ours, theirs) = (plane_towards(face), plane_towards(leaving.face));
        let difference = ours.normal - theirs.normal;
        let length2 = difference.length_squared();
        let offset = ours.normal.dot(ours.point) - theirs.normal.dot(theirs.point);
        let plane = || CutPlane { point: difference * (offset / length2), normal: difference / length2.sqrt() };
        (length2 > NO_DIRECTION).then(plane)
    }

    fn triangle(&self, face: u32) -> [DVec3; 3] {
        corners_f64(self.mesh.faces()[face as usize].map(|v| self.mesh.positions()[v as usize]))
    }

    fn normal(&self, face: u32) -> DVec3 {
        area_normal_f64(self.triangle(face)).normalize_or_zero()
    }
}

/// Returns the squared distance at which a face is near enough, whichever is nearest.
fn near_enough(lower: f64) -> f64 {
    let near = NEAR_SHARE * lower;
    if near > 0.0 { near * near } else { f64::NEG_INFINITY }
}

struct NearSearch<'a> {
    tree: &'a FaceTree<'a>,
    point: DVec3,
    guess: Option<u32>,
    enough: f64,
}

impl Work for NearSearch<'_> {
    type Output = Option<(u32, f64, SearchCost)>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        self.tree.find_near_with_cost(self.point, self.guess, self.enough)
    }
}
