//! Closest points on a set of triangles.

use glam::DVec3;

use super::Bounds;
use super::needle_tree::NeedleTree;
use super::triangle_pieces;
use super::triangle_tree::{OverlapQuery, TreeQuery, TriangleNode, TriangleTree};
use crate::geometry::nearest_on_triangle::nearest_weights_f64;
use crate::geometry::triangle::corners_f64;

/// Ratio of a triangle's largest coordinate to that of all triangles, below which single precision cannot resolve the
/// triangle.
const INNER: f32 = 1.0 / 16_777_216.0;
/// Ratio of the largest coordinate to a point's distance, below which all triangles are equally far.
const FAR: f64 = 1e-18;
const MOST_UNSPLIT: usize = 16;

/// Triangles prepared for closest-point queries; ties go to the first triangle.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::spatial::NearestOnTriangles;
/// let triangle = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let surface = NearestOnTriangles::new(&[triangle]);
/// let hit = surface.nearest([0.25, 0.25, 2.0].into()).unwrap();
/// assert_eq!((hit.triangle, hit.distance2), (0, 4.0));
/// ```
pub struct NearestOnTriangles {
    pub(super) tree: TriangleTree,
    /// Oriented boxes, which replace all nodes if too many triangles are thin.
    pub(super) needles: Option<NeedleTree>,
    /// Power of two that scales coordinates to -1..1.
    pub(super) scale: f64,
    /// Triangles too close to the origin for the common scale.
    pub(super) inner: Option<Box<InnerTriangles>>,
}

pub(super) struct InnerTriangles {
    pub(super) surface: NearestOnTriangles,
    triangles: Vec<[[f32; 3]; 3]>,
    pub(super) triangle_idx: Vec<u32>,
    most: f64,
}

/// A closest point, or the crossing of a line, on the triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The triangle's index.
    pub triangle: u32,
    /// Barycentric weights of the point.
    pub weights: [f64; 3],
    /// Position of the point.
    pub point: DVec3,
    /// Squared distance to the query.
    pub distance2: f64,
}

/// The search for the closest point, or for any triangle within reach.
struct ClosestQuery<'a, A> {
    tree: &'a TriangleTree,
    p: DVec3,
    accept: &'a A,
    hit: Hit,
    limit: f32,
    is_any: bool,
    n_visits: u32,
}

impl NearestOnTriangles {
    /// Builds the tree over finite triangles, n_triangles x 3 x 3.
    pub fn new(triangles: &[[[f32; 3]; 3]]) -> Self {
        let most = largest(triangles.as_flattened());
        let is_inner = |&i: &u32| largest(&triangles[i as usize]) <= most * INNER;
        if (0..triangles.len() as u32).filter(is_inner).count() <= MOST_UNSPLIT || most == 0.0 {
            return Self::with_one_unit(triangles, most);
        }
        let (inner, outer): (Vec<u32>, Vec<u32>) = (0..triangles.len() as u32).partition(is_inner);
        let select_triangles = |idx: &[u32]| idx.iter().map(|&i| triangles[i as usize]).collect::<Vec<_>>();
        let mut nearest = Self::with_one_unit(&select_triangles(&outer), most);
        nearest.tree.triangle_idx.iter_mut().for_each(|i| *i = outer[*i as usize]);
        let near = select_triangles(&inner);
        let most = f64::from(largest(near.as_flattened()));
        nearest.inner =
            Some(Box::new(InnerTriangles { surface: Self::new(&near), triangles: near, triangle_idx: inner, most }));
        nearest
    }

    fn with_one_unit(triangles: &[[[f32; 3]; 3]], most: f32) -> Self {
        let scale = 2f64.powi(unit_exponent(most));
        let scaled: Vec<_> = triangles.iter().map(|corners| corners.map(|corner| to_scale(corner, scale))).collect();
        let cuts: f64 = scaled.iter().map(|corners| f64::from(triangle_pieces::wanted_cuts(corners))).sum();
        if triangle_pieces::are_needles(cuts, scaled.len()) {
            let needles = Some(NeedleTree::new(scaled.iter().copied()));
            return Self { tree: TriangleTree::without_nodes(scaled), needles, scale, inner: None };
        }
        Self { tree: TriangleTree::new(&scaled), needles: None, scale, inner: None }
    }

    /// Returns the closest point; `None` without triangles.
    pub fn nearest(&self, p: DVec3) -> Option<Hit> {
        self.nearest_with_cost(p).0
    }

    /// Searches as [`nearest`](Self::nearest), and also counts the triangles and boxes tested.
    pub fn nearest_with_cost(&self, p: DVec3) -> (Option<Hit>, u32) {
        self.search(p, f64::INFINITY, |_| true, false)
    }

    /// Returns the closest point of the triangles that `accept` allows.
    pub fn nearest_of(&self, p: DVec3, accept: impl Fn(u32) -> bool) -> Option<Hit> {
        self.search(p, f64::INFINITY, accept, false).0
    }

    /// Returns whether a triangle that `accept` allows is within `reach`.
    ///
    /// ```
    /// # use neural_mesh_mesh as neural_mesh;
    /// use neural_mesh::spatial::NearestOnTriangles;
    /// let triangle_at_height = |z: f32| [[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]];
    /// let surface = NearestOnTriangles::new(&[triangle_at_height(0.0), triangle_at_height(1.0)]);
    /// let is_any = |reach: f64| surface.is_within_distance([0.2, 0.2, 0.1].into(), reach, |triangle| triangle != 0);
    /// assert!(is_any(1.0) && !is_any(0.8));
    /// ```
    pub fn is_within_distance(&self, p: DVec3, reach: f64, accept: impl Fn(u32) -> bool) -> bool {
        self.is_within_distance_with_cost(p, reach, accept).0
    }

    /// Returns [`is_within_distance`](Self::is_within_distance) and the number of tested triangles and boxes.
    pub fn is_within_distance_with_cost(&self, p: DVec3, reach: f64, accept: impl Fn(u32) -> bool) -> (bool, u32) {
        let (hit, n_visits) = self.search(p, reach, accept, true);
        (hit.is_some(), n_visits)
    }

    /// Returns the closest point within `reach` of the triangles that `accept` allows.
    ///
    /// ```
    /// # use neural_mesh_mesh as neural_mesh;
    /// use neural_mesh::spatial::NearestOnTriangles;
    /// let surface = NearestOnTriangles::new(&[[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]);
    /// let found = |reach: f64| surface.nearest_within([0.2, 0.2, 0.1].into(), reach, |_| true).is_some();
    /// assert!(found(0.2) && !found(0.05));
    /// ```
    pub fn nearest_within(&self, p: DVec3, reach: f64, accept: impl Fn(u32) -> bool) -> Option<Hit> {
        self.search(p, reach, accept, false).0
    }

    fn search(&self, p: DVec3, reach: f64, accept: impl Fn(u32) -> bool, is_any: bool) -> (Option<Hit>, u32) {
        let (outer, n_visits) = self.search_outer(p, reach, &accept, is_any);
        let Some(inner) = self.inner.as_ref().filter(|_| !is_any || outer.is_none()) else { return (outer, n_visits) };
        let reach = outer.map_or(reach, |hit| hit.distance2.sqrt());
        let (nearer, n_more) = inner.search(p, reach, &accept, is_any);
        let by_distance = |a: &Hit, b: &Hit| a.distance2.total_cmp(&b.distance2).then(a.triangle.cmp(&b.triangle));
        ([outer, nearer].into_iter().flatten().min_by(by_distance), n_visits + n_more)
    }

    fn search_outer(&self, p: DVec3, reach: f64, accept: &impl Fn(u32) -> bool, is_any: bool) -> (Option<Hit>, u32) {
        let (p, reach) = (p * self.scale, reach * self.scale);
        let hit = Hit { triangle: u32::MAX, weights: [0.0; 3], point: p, distance2: reach * reach };
        let limit = limit(reach * reach, p);
        let mut query = ClosestQuery { tree: &self.tree, p, accept, hit, limit, is_any, n_visits: 0 };
        match &self.needles {
            Some(needles) => query.visit_needles(needles),
            None => self.tree.search(&mut query),
        }
        let ClosestQuery { hit, n_visits, .. } = query;
        let (point, distance2) = (hit.point / self.scale, hit.distance2 / (self.scale * self.scale));
        ((hit.triangle != u32::MAX).then_some(Hit { point, distance2, ..hit }), n_visits)
    }

    /// Calls `visit`, possibly repeatedly, for every triangle that meets a triangle, and for some near it.
    pub fn visit_touching(&self, corners: &[[f32; 3]; 3], mut visit: impl FnMut(u32)) {
        let scaled = corners.map(|corner| to_scale(corner, self.scale));
        if let Some(needles) = &self.needles {
            let leaf = |leaf: &[u32]| leaf.iter().for_each(|&i| visit(self.tree.triangle_idx[i as usize]));
            needles.visit_touching(corners_f64(scaled), leaf);
        } else {
            let bounds = Bounds::from_points(&scaled);
            self.tree.search(&mut OverlapQuery { tree: &self.tree, bounds, visit: &mut visit });
        }
        if let Some(inner) = &self.inner {
            // A reference, since a generic type would nest without end.
            let visit: &mut dyn FnMut(u32) = &mut |i: u32| visit(inner.triangle_idx[i as usize]);
            inner.surface.visit_touching(corners, visit);
        }
    }
}

impl<A: Fn(u32) -> bool> ClosestQuery<'_, A> {
    fn visit_needles(&mut self, needles: &NeedleTree) {
        let n_boxes = needles.visit_near(self.p, self.hit.distance2, |leaf| {
            leaf.iter().for_each(|&i| self.test(i as usize));
            let is_done = self.is_any && self.hit.triangle != u32::MAX;
            if is_done { f64::NEG_INFINITY } else { self.hit.distance2 }
        });
        self.n_visits += n_boxes;
    }
}

impl<A: Fn(u32) -> bool> TreeQuery for ClosestQuery<'_, A> {
    #[inline(always)]
    fn distances(&mut self, node: &TriangleNode) -> [f32; 4] {
        self.n_visits += 1;
        let mut distances = [0.0; 4];
        for (axis, p) in self.p.as_vec3().to_array().into_iter().enumerate() {
            for (child, distance) in distances.iter_mut().enumerate() {
                let outside = (node.low[axis][child] - p).max(p - node.high[axis][child]).max(0.0);
                *distance += outside * outside;
            }
        }
        distances
    }

    fn reaches(&self, distance: f32) -> bool {
        distance <= self.limit
    }

    fn test(&mut self, i: usize) {
        let triangle = self.tree.triangle_idx[i];
        if !(self.accept)(triangle) {
            return;
        }
        self.n_visits += 1;
        let hit = hit_triangle(&self.tree.corners[i], triangle, self.p);
        if (hit.distance2, hit.triangle) < (self.hit.distance2, self.hit.triangle) {
            self.hit = hit;
            self.limit = if self.is_any { f32::NEG_INFINITY } else { limit(hit.distance2, self.p) };
        }
    }
}

impl InnerTriangles {
    /// Searches these triangles within `reach` of `p`; if `p` is very far away, returns the first accepted one.
    fn search(&self, p: DVec3, reach: f64, accept: &dyn Fn(u32) -> bool, is_any: bool) -> (Option<Hit>, u32) {
        let outside = (p.abs() - DVec3::splat(self.most)).max(DVec3::ZERO).length();
        if outside > reach {
            return (None, 1);
        }
        let is_accepted: &dyn Fn(u32) -> bool = &|i: u32| accept(self.triangle_idx[i as usize]);
        let (hit, n_visits) = if outside * FAR > self.most {
            let first = (0..self.triangle_idx.len() as u32).find(|&i| is_accepted(i));
            (first.map(|first| hit_triangle(&self.triangles[first as usize], first, p)), 1)
        } else {
            // Rounding may make the squared distance slightly larger in this scale.
            self.surface.search(p, reach * (1.0 + 1e-12), is_accepted, is_any)
        };
        (hit.map(|hit| Hit { triangle: self.triangle_idx[hit.triangle as usize], ..hit }), n_visits)
    }
}

#[inline(always)]
pub(super) fn hit_triangle(corners: &[[f32; 3]; 3], triangle: u32, p: DVec3) -> Hit {
    let corners = corners_f64(*corners);
    let weights = nearest_weights_f64(p, corners);
    let point = corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2];
    Hit { triangle, weights, point, distance2: p.distance_squared(point) }
}

fn largest(points: &[[f32; 3]]) -> f32 {
    points.as_flattened().iter().fold(0.0, |most: f32, x| most.max(x.abs()))
}

/// Returns the exponent of the power of two that scales coordinates of up to `most` to -1..1.
pub(super) fn unit_exponent(most: f32) -> i32 {
    if most > 0.0 { -(f64::from(most).log2().ceil() as i32) } else { 0 }
}

fn to_scale(point: [f32; 3], scale: f64) -> [f32; 3] {
    point.map(|x| (f64::from(x) * scale) as f32)
}

/// Returns the squared distance from `p` beyond which a box in -1..1 can be skipped.
pub(super) fn limit(distance2: f64, p: DVec3) -> f32 {
    let rounding = p.abs().max_element().max(1.0) * 4e-7;
    let reach = distance2.sqrt() + rounding;
    (reach * reach * (1.0 + 1e-6)) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::crossing::triangles_cross;
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rand_xoshiro::rand_core::{Rng, SeedableRng};

    fn naive(triangles: &[[[f32; 3]; 3]], p: DVec3) -> (f64, u32) {
        let distance2 = |corners: &[[f32; 3]; 3]| {
            let corners = corners_f64(*corners);
            let [u, v, w] = nearest_weights_f64(p, corners);
            p.distance_squared(corners[0] * u + corners[1] * v + corners[2] * w)
        };
        let all = triangles.iter().zip(0..).map(|(corners, i)| (distance2(corners), i));
        all.min_by(|a, b| a.partial_cmp(b).unwrap()).unwrap()
    }

    fn random_triangles(n: usize, size: f32, offset: f32) -> Vec<[[f32; 3]; 3]> {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(n as u64);
        let mut unit = || rng.next_u32() as f32 / u32::MAX as f32;
        let mut triangle = || {
            let at = [unit() + offset, unit(), unit()];
            [(); 3].map(|()| at.map(|x| x + size * unit()))
        };
        (0..n).map(|_| triangle()).collect()
    }

    fn check(triangles: &[[[f32; 3]; 3]], offset: f64) {
        let surface = NearestOnTriangles::new(triangles);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
        let mut unit = || 3.0 * f64::from(rng.next_u32()) / f64::from(u32::MAX) - 1.0;
        for _ in 0..60 {
            let p = DVec3::new(unit() + offset, unit(), unit());
            let hit = surface.nearest(p).unwrap();
            assert_eq!((hit.distance2, hit.triangle), naive(triangles, p));
        }
    }

    #[test]
    fn agrees_with_brute_force() {
        for n in [1, 2, 5, 17, 300] {
            check(&random_triangles(n, 0.1, 0.0), 0.0);
        }
        check(&random_triangles(300, 1e-3, 0.0), 0.0);
        check(&random_triangles(300, 2.0, 0.0), 0.0);
        check(&random_triangles(300, 0.1, 5e4), 5e4);
    }

    #[test]
    fn coordinates_whose_squares_are_out_of_range_are_no_trouble() {
        for scale in [1e-42, 1e-25, 1e25, 1e37] {
            let triangles = random_triangles(100, 0.1, 0.0).into_iter().map(|t| t.map(|p| p.map(|x| x * scale)));
            let surface = NearestOnTriangles::new(&triangles.collect::<Vec<_>>());
            let unscaled = NearestOnTriangles::new(&random_triangles(100, 0.1, 0.0));
            let p = DVec3::new(0.3, 0.4, 0.2);
            let (hit, wanted) = (surface.nearest(p * f64::from(scale)).unwrap(), unscaled.nearest(p).unwrap());
            assert_eq!(hit.triangle, wanted.triangle);
            assert!((hit.distance2.sqrt() / f64::from(scale) - wanted.distance2.sqrt()).abs() < 1e-2);
        }
    }

    #[test]
    fn sizes_of_every_magnitude_are_told_apart() {
        let mut triangles = random_triangles(400, 1.0, 0.0);
        for (i, corner) in triangles.iter_mut().flatten().enumerate() {
            let size = 10f32.powi((i as i32 * 7) % 75 - 37);
            *corner = corner.map(|x| (x - 0.5) * if i % 3 == 0 { size } else { 1e-37 });
        }
        let small: Vec<_> =
            random_triangles(300, 0.1, 0.0).into_iter().map(|t| t.map(|p| p.map(|x| 1e-12 * x))).collect();
        triangles.extend(small);
        let surface = NearestOnTriangles::new(&triangles);
        let mut units = 1;
        let mut inner = &surface.inner;
        while let Some(next) = inner {
            (units, inner) = (units + 1, &next.surface.inner);
        }
        assert!(units > 3, "{units}");
        for &corner in triangles.iter().flatten().step_by(5) {
            let p = glam::Vec3::from(corner).as_dvec3() * 1.25;
            let hit = surface.nearest(p).unwrap();
            let (distance2, _) = naive(&triangles, p);
            let (found, expected) = (hit.distance2.sqrt(), distance2.sqrt());
            // Smallest number of the common scale.
            let least = 2f64.powi(-148) * f64::from(largest(triangles.as_flattened()));
            assert!((found - expected).abs() <= 1e-15 * expected + least, "{p} {hit:?} {expected}");
        }
    }

    #[test]
    fn needles_around_a_hub_are_distinguished() {
        let rim = |i: i32| [(0.01 * i as f32).cos(), (0.01 * i as f32).sin(), 0.3 * (0.01 * i as f32).sin()];
        let fan: Vec<_> = (0..629).map(|i| [[0.0; 3], rim(i), rim(i + 1)]).collect();
        check(&fan, 0.0);
    }

    #[test]
    fn ties_go_to_the_first_triangle() {
        let triangles = [[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]; 50];
        let hit = NearestOnTriangles::new(&triangles).nearest([0.2, 0.2, 1.0].into()).unwrap();
        assert_eq!(hit.triangle, 0);
    }

    #[test]
    fn no_triangles_have_no_nearest_point() {
        assert!(NearestOnTriangles::new(&[]).nearest(DVec3::ZERO).is_none());
    }

    #[test]
    fn one_point_many_times_and_scales_that_shrink_do_not_make_the_tree_deep() {
        check(&vec![[[0.5; 3]; 3]; 1000], 0.0);
        let shrinking: Vec<_> = (0..120).map(|i| [[0.5f32.powi(i); 3]; 3]).collect();
        check(&shrinking, 0.0);
    }

    #[test]
    fn boxes_along_the_needles_of_a_fan_find_the_same() {
        let rim = |i: i32| [(1.5e-4 * i as f32).cos(), (1.5e-4 * i as f32).sin(), 0.0];
        let fan: Vec<_> = (0..20_000).map(|i| [[0.0; 3], rim(i), rim(i + 1)]).collect();
        let surface = NearestOnTriangles::new(&fan);
        assert!(surface.needles.is_some() && surface.tree.nodes.is_empty());
        check(&fan, 0.0);
        let p = DVec3::new(0.4, 0.3, 0.25);
        let (hit, n_visits) = surface.nearest_with_cost(p);
        assert!((hit.unwrap().distance2 - 0.0625).abs() < 1e-12 && n_visits < 400, "{hit:?} {n_visits}");
        assert!(surface.is_within_distance(p, 0.26, |i| i < 6000) && !surface.is_within_distance(p, 0.24, |_| true));
    }

    #[test]
    fn what_meets_a_triangle_is_among_what_is_visited() {
        let rim = |i: i32| [(1e-4 * i as f32).cos(), (1e-4 * i as f32).sin(), 0.1 * (1e-3 * i as f32).sin()];
        let fan: Vec<_> = (0..20_000).map(|i| [[0.0; 3], rim(i), rim(i + 1)]).collect();
        for triangles in [random_triangles(200, 0.4, 0.0), fan] {
            let surface = NearestOnTriangles::new(&triangles);
            let query = [[0.3, 0.3, -0.4], [0.6, 0.4, 0.3], [0.5, 0.6, 0.6]];
            let mut found = Vec::new();
            surface.visit_touching(&query, |i| found.push(i as usize));
            let (met, others): (Vec<usize>, Vec<usize>) =
                (0..triangles.len()).partition(|&i| triangles_cross(triangles[i], query));
            assert!(!met.is_empty() && met.iter().all(|i| found.contains(i)));
            assert!(others.iter().filter(|i| found.contains(i)).count() < triangles.len() / 2);
        }
    }
}
