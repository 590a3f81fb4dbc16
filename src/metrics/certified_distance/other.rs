//! The surface that distances are measured to, and the planes between its faces.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use super::bounds::Bounds;
use super::piece::{Corner, Plane, reach};
use crate::geometry::nearest_on_triangle::nearest_weights_f64;
use crate::geometry::triangle::area_normal_f64;
use crate::mesh::TriMesh;
use crate::spatial::{FaceTree, Looks};

/// Squared length of the sum or difference of two unit normals below which it has no direction.
const NO_DIRECTION: f64 = 1e-12;
/// Vertices that are looked up before it is asked whether that costs too much.
const AT_ONCE: usize = 2048;
/// So much may always be looked at once: in a round of searches on most surfaces.
const LITTLE: u64 = 1_000_000;
/// Items begun at once however much they look at.
const FEWEST: usize = 16;
/// Vertices of which each is looked for around the face of the one before.
const IN_A_ROW: usize = 32;

/// The surface that distances are measured to.
pub(super) struct Other<'a> {
    mesh: &'a TriMesh,
    tree: &'a FaceTree<'a>,
    /// Triangles and boxes that were looked at, and how many may be: asked between rounds of searches that do not depend on it.
    n_looks: AtomicU64,
    most_looks: u64,
    /// Whether boxes count.
    with_boxes: bool,
    /// Searches that looked at them.
    n_searches: AtomicU64,
}

impl<'a> Other<'a> {
    /// A surface on which so much is looked at, at most, and a round of searches more.
    pub(super) fn new(mesh: &'a TriMesh, tree: &'a FaceTree<'a>, most_looks: u64) -> Self {
        Self { mesh, tree, n_looks: AtomicU64::new(0), most_looks, with_boxes: true, n_searches: AtomicU64::new(0) }
    }

    /// The same where only triangles count.
    pub(super) fn of_triangles(self) -> Self {
        Self { with_boxes: false, ..self }
    }

    /// How many triangles and boxes were looked at.
    pub(super) fn n_looks(&self) -> u64 {
        self.n_looks.load(Ordering::Relaxed)
    }

    /// Whether as much was looked at as may be.
    pub(super) fn is_exhausted(&self) -> bool {
        self.n_looks() >= self.most_looks
    }

    /// How many items of so many searches each may be begun at once, `most` unless they may look at more than is left.
    pub(super) fn at_once(&self, most: usize, n_searches: u64) -> usize {
        let each = self.n_looks() / self.n_searches.load(Ordering::Relaxed).max(1);
        let left = self.most_looks.saturating_sub(self.n_looks()).max(LITTLE);
        (left / (n_searches * each).max(1)).clamp(FEWEST as u64, most as u64) as usize
    }

    /// What is known at a point, sooner where its nearest face is near the one guessed.
    pub(super) fn corner(&self, point: DVec3, guess: Option<u32>) -> Corner {
        let found = self.tree.near_counted(point, guess, f64::NEG_INFINITY);
        let (face, distance2, looks) = found.unwrap_or((0, f64::INFINITY, Looks::default()));
        let n_looks = if self.with_boxes { looks.all() } else { looks.triangles };
        self.n_looks.fetch_add(n_looks.into(), Ordering::Relaxed);
        self.n_searches.fetch_add(1, Ordering::Relaxed);
        Corner { point, distance: distance2.sqrt(), face }
    }

    /// What is known at a point by one face, no farther than `enough` or exact.
    pub(super) fn corner_by(&self, face: u32, point: DVec3, enough: f64) -> Corner {
        let corner = Corner { point, distance: self.distance_to(face, point), face };
        if corner.distance <= enough { corner } else { self.corner(point, Some(face)) }
    }

    /// What is known at every vertex of a mesh, or at the first ones where more cost too much, or where one with a face is farther
    /// than all may be.
    pub(super) fn corners_of(&self, from: &TriMesh, bounds: &Bounds) -> Vec<Corner> {
        let mut corners: Vec<Corner> = Vec::with_capacity(from.positions().len());
        let mut is_used = vec![false; from.positions().len()];
        from.faces().iter().flatten().for_each(|&v| is_used[v as usize] = true);
        let mut is_too_far = bounds.is_beyond();
        while corners.len() < is_used.len() && !self.is_exhausted() && !is_too_far {
            let first = corners.len();
            let n = if first == 0 { 2 * FEWEST } else { self.at_once(AT_ONCE, 1) };
            let positions = &from.positions()[first..is_used.len().min(first + n)];
            corners.par_extend(positions.par_chunks(IN_A_ROW).flat_map_iter(|row| self.corners_in_a_row(row)));
            let is_far = |(corner, &is_used): (&Corner, &bool)| is_used && corner.distance > bounds.asked.too_much;
            is_too_far = corners[first..].iter().zip(&is_used[first..]).any(is_far);
        }
        corners
    }

    /// What is known at points of which each is near the one before.
    fn corners_in_a_row(&self, points: &[[f32; 3]]) -> impl Iterator<Item = Corner> {
        let mut last = None;
        points.iter().map(move |p| {
            let corner = self.corner(DVec3::from(p.map(f64::from)), last);
            last = Some(corner.face);
            corner
        })
    }

    /// How far a part with these corners may be from the surface, by the faces nearest to its corners and by the way to the
    /// nearest corner; no sharper than what is allowed.
    pub(super) fn upper(&self, corners: &[Corner], allows: impl Fn(f64) -> bool) -> f64 {
        let mut upper = f64::INFINITY;
        for (i, corner) in corners.iter().enumerate() {
            upper = upper.min(corner.distance + reach(corners, corner));
            let is_new = || corners[..i].iter().all(|before| before.face != corner.face);
            if !allows(upper) && is_new() {
                upper = upper.min(self.farthest_from(corners, corner.face));
            }
            if allows(upper) {
                return upper;
            }
        }
        upper
    }

    /// How far the farthest point between the corners is from one face: one of the corners is.
    pub(super) fn farthest_from(&self, corners: &[Corner], face: u32) -> f64 {
        corners.iter().map(|corner| self.distance(corner, face)).fold(0.0, f64::max)
    }

    fn distance(&self, corner: &Corner, face: u32) -> f64 {
        if corner.face == face { corner.distance } else { self.distance_to(face, corner.point) }
    }

    fn distance_to(&self, face: u32, point: DVec3) -> f64 {
        let [a, b, c] = self.triangle(face);
        let weights = nearest_weights_f64(point, [a, b, c]);
        (a * weights[0] + b * weights[1] + c * weights[2]).distance(point)
    }

    /// The planes that stand on the sides of a face: between them its points are the nearest, but for what curves around.
    /// (Planes halfway to the neighbours' normals save one cut in twenty, and cost the search for the neighbours.)
    pub(super) fn walls(&self, face: u32) -> [Plane; 3] {
        let [a, b, c] = self.triangle(face);
        let normal = self.normal(face);
        let wall = |from: DVec3, to: DVec3| Plane { point: from, normal: normal.cross(to - from).normalize_or_zero() };
        [wall(a, b), wall(b, c), wall(c, a)]
    }

    /// The plane whose points are as far from the plane of `face` as from that of the face which the part leaves it for.
    pub(super) fn bisector(&self, corners: &[Corner], face: u32) -> Option<Plane> {
        let gained = |corner: &Corner| self.distance(corner, face) - corner.distance;
        let apart = corners.iter().filter(|corner| corner.face != face);
        let leaving = apart.max_by(|x, y| gained(x).total_cmp(&gained(y)))?;
        let plane_towards = |face: u32| {
            let (point, normal) = (self.triangle(face)[0], self.normal(face));
            Plane { point, normal: if normal.dot(leaving.point - point) < 0.0 { -normal } else { normal } }
        };
        let (ours, theirs) = (plane_towards(face), plane_towards(leaving.face));
        let difference = ours.normal - theirs.normal;
        let length2 = difference.length_squared();
        let offset = ours.normal.dot(ours.point) - theirs.normal.dot(theirs.point);
        let plane = || Plane { point: difference * (offset / length2), normal: difference / length2.sqrt() };
        (length2 > NO_DIRECTION).then(plane)
    }

    fn triangle(&self, face: u32) -> [DVec3; 3] {
        self.mesh.faces()[face as usize].map(|v| DVec3::from(self.mesh.positions()[v as usize].map(f64::from)))
    }

    fn normal(&self, face: u32) -> DVec3 {
        area_normal_f64(self.triangle(face)).normalize_or_zero()
    }
}
