//! Tests whether a ray meets any triangle.

use glam::{DVec3, Vec3};

use crate::geometry::extent;
use crate::geometry::line_on_triangle::line_on_triangle;
use crate::geometry::triangle::corners_f64;

use super::triangle_tree::{TreeQuery, TriangleNode, TriangleTree};

/// Margin of triangles, in barycentric weights, so that no ray passes through an edge.
const MARGIN: f64 = 1e-4;

/// Triangles prepared for occlusion tests.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::spatial::Occluders;
/// let wall = Occluders::new(&[[[1.0, -1.0, -1.0], [1.0, 3.0, -1.0], [1.0, -1.0, 3.0]]]);
/// let toward = |x: f64| wall.is_blocked([0.0; 3].into(), [x, 0.0, 0.0].into(), 0.0);
/// assert!(toward(1.0) && !toward(-1.0));
/// assert!(!wall.is_blocked([0.0; 3].into(), [1.0, 0.0, 0.0].into(), 1.5));
/// ```
pub struct Occluders {
    tree: TriangleTree,
    middle: DVec3,
    factor: f64,
}

impl Occluders {
    /// Builds the tree over finite triangles, n_triangles x 3 x 3.
    pub fn new(triangles: &[[[f32; 3]; 3]]) -> Self {
        let (low, high) = extent(triangles.as_flattened().iter().map(|corner| corner.map(f64::from).into()));
        let half = (0.5 * (high - low)).max_element();
        let (middle, factor) = if half > 0.0 { (0.5 * (low + high), half.recip()) } else { (DVec3::ZERO, 1.0) };
        let to_unit = |corner: [f32; 3]| ((Vec3::from(corner).as_dvec3() - middle) * factor).as_vec3().to_array();
        let scaled: Vec<_> = triangles.iter().map(|corners| corners.map(to_unit)).collect();
        Self { tree: TriangleTree::new(&scaled), middle, factor }
    }

    /// Returns whether a ray meets a triangle at distance `start` or more.
    pub fn is_blocked(&self, from: DVec3, direction: DVec3, start: f64) -> bool {
        let direction = direction.normalize_or_zero();
        if direction == DVec3::ZERO {
            return false;
        }
        let mut ray = Ray::new(&self.tree, (from - self.middle) * self.factor, direction, start * self.factor);
        self.tree.search(&mut ray);
        ray.is_blocked
    }
}

struct Ray<'a> {
    tree: &'a TriangleTree,
    is_blocked: bool,
    from: DVec3,
    direction: DVec3,
    start: f64,
    near: [f32; 3],
    slope: [f32; 3],
}

impl<'a> Ray<'a> {
    fn new(tree: &'a TriangleTree, from: DVec3, direction: DVec3, start: f64) -> Self {
        let slope = direction.to_array().map(|x| (1.0 / if x.abs() < 1e-12 { 1e-12f64.copysign(x) } else { x }) as f32);
        Self { tree, is_blocked: false, from, direction, start, near: from.as_vec3().to_array(), slope }
    }

    fn meets(&self, corners: &[[f32; 3]; 3]) -> bool {
        let corners = corners_f64(*corners);
        let [v, w, far] = line_on_triangle(self.from, self.direction, corners);
        v >= -MARGIN && w >= -MARGIN && v + w <= 1.0 + MARGIN && far >= self.start
    }
}

impl TreeQuery for Ray<'_> {
    #[inline(always)]
    fn distances(&mut self, node: &TriangleNode) -> [f32; 4] {
        let [enter, leave] = node.line_ranges(self.near, self.slope, 0.0);
        std::array::from_fn(|i| if enter[i] <= leave[i] * (1.0 + 1e-5) { enter[i] } else { f32::INFINITY })
    }

    fn reaches(&self, distance: f32) -> bool {
        !self.is_blocked && distance < f32::INFINITY
    }

    fn test(&mut self, i: usize) {
        self.is_blocked |= self.meets(&self.tree.corners[i]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn naive(corners: [[f32; 3]; 3], from: DVec3, direction: DVec3) -> Option<bool> {
        let [a, b, c] = corners_f64(corners);
        let normal = (b - a).cross(c - a);
        let slope = normal.dot(direction);
        if slope.abs() < 1e-6 * normal.length() || normal.length() < 1e-9 {
            return None;
        }
        let t = normal.dot(a - from) / slope;
        let p = from + t * direction;
        let part = |p: DVec3, q: DVec3, r: DVec3| (q - p).cross(r - p).dot(normal) / normal.length_squared();
        let weights = [part(p, b, c), part(a, p, c), part(a, b, p)];
        let least = weights.into_iter().fold(f64::INFINITY, f64::min);
        if t.abs() < 1e-6 || least.abs() < 1e-3 { None } else { Some(t > 0.0 && least > 0.0) }
    }

    proptest! {
        #[test]
        fn it_finds_what_a_search_of_all_finds(
            corners in prop::collection::vec(prop::array::uniform3(-5.0f32..9.0), 3..300),
            from in prop::array::uniform3(-12.0f64..12.0),
            direction in prop::array::uniform3(-1.0f64..1.0),
        ) {
            let triangles: Vec<[[f32; 3]; 3]> = corners.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect();
            let (from, direction) = (from.into(), DVec3::from(direction).normalize_or(DVec3::X));
            let known: Vec<Option<bool>> = triangles.iter().map(|&corners| naive(corners, from, direction)).collect();
            let is_blocked = Occluders::new(&triangles).is_blocked(from, direction, 0.0);
            if known.contains(&Some(true)) {
                prop_assert!(is_blocked);
            } else if !known.contains(&None) {
                prop_assert!(!is_blocked);
            }
        }
    }

    #[test]
    fn nothing_slips_through_the_edges_of_a_closed_surface() {
        let sphere = crate::mesh::shapes::icosphere(2);
        let triangles: Vec<[[f32; 3]; 3]> =
            sphere.faces().iter().map(|face| face.map(|v| sphere.positions()[v as usize])).collect();
        let occluders = Occluders::new(&triangles);
        // Directions toward each vertex and each edge's middle.
        let points = |[a, b, c]: [[f32; 3]; 3]| {
            let [a, b, c] = corners_f64([a, b, c]);
            [a, 0.5 * (a + b), 0.5 * (b + c)]
        };
        let from = DVec3::new(0.1, 0.2, -0.05);
        assert!(triangles.iter().flat_map(|&t| points(t)).all(|p| occluders.is_blocked(from, p - from, 0.0)));
        assert!(triangles.iter().flat_map(|&t| points(t)).all(|p| !occluders.is_blocked(1.01 * p, p, 0.0)));
        assert!(!Occluders::new(&[]).is_blocked(from, DVec3::X, 0.0));
    }
}
