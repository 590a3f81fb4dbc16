//! Finds the first crossing of a line with triangles.

use glam::DVec3;

use crate::geometry::line_on_triangle::line_on_triangle;
use crate::geometry::triangle::corners_f64;

use super::nearest_on_triangles::{Hit, NearestOnTriangles};
use super::triangle_tree::{LINE_MARGIN, TreeQuery, TriangleNode, TriangleTree};

/// Margin around a triangle, relative to its size, so that no line passes between two.
const WIDER: f64 = 1e-6;

struct LineQuery<'a> {
    tree: &'a TriangleTree,
    accept: &'a dyn Fn(u32) -> bool,
    from: DVec3,
    along: DVec3,
    from32: [f32; 3],
    inverse: [f32; 3],
    /// Distance of the nearest crossing so far, or the limit of the search.
    reach: f64,
    hit: Option<Hit>,
}

impl NearestOnTriangles {
    /// Returns the crossing nearest to `p`, ahead or behind, of the line along `direction` with triangles that `accept`
    /// allows.
    ///
    /// `None` if there is none within `reach`, or the direction has no length. Ties go to the first triangle.
    ///
    /// ```
    /// # use neural_mesh_mesh as neural_mesh;
    /// use neural_mesh::spatial::NearestOnTriangles;
    /// let triangle_at_height = |z: f32| [[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]];
    /// let surface = NearestOnTriangles::new(&[triangle_at_height(1.0), triangle_at_height(-2.0)]);
    /// let hit = |reach: f64| surface.crossing_along([0.2, 0.2, 0.0].into(), [0.0, 0.0, -5.0].into(), reach, |_| true);
    /// assert_eq!(hit(3.0).map(|hit| (hit.triangle, hit.distance2)), Some((0, 1.0)));
    /// assert_eq!(hit(0.5), None);
    /// ```
    pub fn crossing_along(&self, p: DVec3, direction: DVec3, reach: f64, accept: impl Fn(u32) -> bool) -> Option<Hit> {
        self.crossing_along_unit(p, direction.try_normalize()?, reach, &accept)
    }

    /// Searches along a unit direction; `accept` is a reference, since a generic type would nest without end.
    fn crossing_along_unit(&self, p: DVec3, along: DVec3, reach: f64, accept: &dyn Fn(u32) -> bool) -> Option<Hit> {
        let outer = self.outer_crossing_along(p, along, reach, accept);
        let inner = self.inner.as_ref().and_then(|inner| {
            let nearer = outer.map_or(reach, |hit| hit.distance2.sqrt());
            let hit =
                inner.surface.crossing_along_unit(p, along, nearer, &|i| accept(inner.triangle_idx[i as usize]))?;
            Some(Hit { triangle: inner.triangle_idx[hit.triangle as usize], ..hit })
        });
        let order = |a: &Hit, b: &Hit| a.distance2.total_cmp(&b.distance2).then(a.triangle.cmp(&b.triangle));
        [outer, inner].into_iter().flatten().min_by(order)
    }

    fn outer_crossing_along(&self, p: DVec3, along: DVec3, reach: f64, accept: &dyn Fn(u32) -> bool) -> Option<Hit> {
        let from = p * self.scale;
        let inverse = along.as_vec3().recip().to_array();
        let from32 = from.as_vec3().to_array();
        let (tree, reach) = (&self.tree, reach * self.scale);
        let mut line = LineQuery { tree, accept, from, along, from32, inverse, reach, hit: None };
        if let Some(needles) = &self.needles {
            // Coordinates are at most 1: a longer line meets nothing more.
            let reach = reach.min(4.0 + from.length());
            let [begin, end] = [-reach, reach].map(|reach| from + reach * along);
            needles.visit_touching([begin, end, end], |leaf| leaf.iter().for_each(|&i| line.test(i as usize)));
        } else {
            tree.search(&mut line);
        }
        let hit = line.hit?;
        let distance2 = hit.distance2 / (self.scale * self.scale);
        Some(Hit { point: hit.point / self.scale, distance2, ..hit })
    }
}

impl TreeQuery for LineQuery<'_> {
    fn distances(&mut self, node: &TriangleNode) -> [f32; 4] {
        let [begin, end] = node.line_ranges(self.from32, self.inverse, f32::NEG_INFINITY);
        std::array::from_fn(|i| if begin[i] <= end[i] { begin[i].max(-end[i]) } else { f32::INFINITY })
    }

    fn reaches(&self, distance: f32) -> bool {
        distance <= self.reach as f32 + LINE_MARGIN && distance < f32::INFINITY
    }

    fn test(&mut self, i: usize) {
        let triangle = self.tree.triangle_idx[i];
        if (self.accept)(triangle) {
            self.meet(&self.tree.corners[i], triangle);
        }
    }
}

impl LineQuery<'_> {
    fn meet(&mut self, corners: &[[f32; 3]; 3], triangle: u32) {
        let [a, b, c] = corners_f64(*corners);
        let [v, w, far] = line_on_triangle(self.from, self.along, [a, b, c]);
        let is_within = v >= -WIDER && w >= -WIDER && v + w <= 1.0 + WIDER;
        let far = far.abs();
        if !is_within || !far.is_finite() || far > self.reach {
            return;
        }
        let known = self.hit.map_or(u32::MAX, |hit| hit.triangle);
        if far < self.reach || triangle < known {
            let weights = [1.0 - v - w, v, w];
            self.hit = Some(Hit { triangle, weights, point: a + (b - a) * v + (c - a) * w, distance2: far * far });
            self.reach = far;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spatial::Bounds;
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rand_xoshiro::rand_core::{Rng, SeedableRng};

    fn numbers(seed: u64) -> impl FnMut() -> f32 {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        move || 2.0 * (rng.next_u32() as f32 / u32::MAX as f32) - 1.0
    }

    fn triangles(n: usize, size: f32) -> Vec<[[f32; 3]; 3]> {
        let mut unit = numbers(n as u64);
        let mut triangle = || {
            let at = [(); 3].map(|()| unit());
            [(); 3].map(|()| at.map(|x| x + size * unit()))
        };
        (0..n).map(|_| triangle()).collect()
    }

    fn naive(triangles: &[[[f32; 3]; 3]], from: DVec3, along: DVec3, reach: f64) -> Option<(u32, f64)> {
        let (tree, accept) = (&TriangleTree::without_nodes(triangles.to_vec()), &|_| true);
        let (along, unused) = (along.normalize(), [0.0; 3]);
        let mut line = LineQuery { tree, accept, from, along, from32: unused, inverse: unused, reach, hit: None };
        (0..triangles.len()).for_each(|i| line.test(i));
        line.hit.map(|hit| (hit.triangle, hit.distance2.sqrt()))
    }

    #[test]
    fn agrees_with_brute_force() {
        for (n, size) in [(1, 1.0), (40, 0.5), (3000, 0.05)] {
            let triangles = triangles(n, size);
            let surface = NearestOnTriangles::new(&triangles);
            let mut unit = numbers(5);
            let mut n_hits = 0;
            for _ in 0..500 {
                let [from, along] = [(); 2].map(|()| DVec3::from([(); 3].map(|()| f64::from(unit()))));
                let reach = f64::from(unit().abs());
                let found = surface
                    .crossing_along(from, along, reach, |_| true)
                    .map(|hit| (hit.triangle, hit.distance2.sqrt()));
                let wanted = naive(&triangles, from, along, reach);
                let is_same = match (found, wanted) {
                    (Some(found), Some(wanted)) => found.0 == wanted.0 && (found.1 - wanted.1).abs() < 1e-12,
                    (found, wanted) => found == wanted,
                };
                assert!(is_same, "{found:?} {wanted:?}");
                n_hits += usize::from(found.is_some());
            }
            assert!(n_hits > if n == 1 { 3 } else { 100 }, "{n}: {n_hits}");
        }
    }

    #[test]
    fn needles_of_a_fan_are_met_too() {
        let rim = |i: u32| [(i as f32 * 3e-4).cos(), (i as f32 * 3e-4).sin(), 0.3 * (i as f32 * 1e-3).sin()];
        let fan: Vec<[[f32; 3]; 3]> = (0..20_000).map(|i| [[0.0; 3], rim(i), rim(i + 1)]).collect();
        let surface = NearestOnTriangles::new(&fan);
        assert!(surface.needles.is_some());
        for (from, along) in
            [([0.3, 0.4, 0.5], DVec3::Z), ([-0.2, 0.5, 0.1], DVec3::new(0.1, -0.2, 1.0)), ([3.0, 3.0, 0.0], DVec3::Z)]
        {
            let found = surface.crossing_along(from.into(), along, f64::INFINITY, |_| true);
            let wanted = naive(&fan, from.into(), along, f64::INFINITY);
            assert_eq!(found.map(|hit| hit.triangle), wanted.map(|(triangle, _)| triangle));
            assert_eq!(found.is_some(), from[0] < 1.0);
        }
    }

    #[test]
    fn lines_along_axes_meet_flat_boxes() {
        let floor = |x: f32| [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.0]];
        let surface = NearestOnTriangles::new(&(0..40).map(|x| floor(x as f32)).collect::<Vec<_>>());
        for axis in [DVec3::Z, -DVec3::Z] {
            let hit = surface.crossing_along([7.25, 0.25, 0.5].into(), axis, 1.0, |_| true).unwrap();
            assert_eq!((hit.triangle, hit.distance2, hit.point), (7, 0.25, DVec3::new(7.25, 0.25, 0.0)));
        }
        assert!(surface.crossing_along([7.25, 0.25, 0.5].into(), DVec3::X, 9.0, |_| true).is_none());
        assert!(surface.crossing_along([7.25, 0.25, 0.5].into(), DVec3::ZERO, 9.0, |_| true).is_none());
    }

    #[test]
    fn edges_let_nothing_through_and_the_first_triangle_wins() {
        let corners: [[f32; 3]; 4] = [[0.1, 0.2, 0.3], [1.3, 0.4, 0.1], [0.9, 1.7, 0.2], [-0.3, 1.1, 0.4]];
        let [a, b, c, d] = corners;
        let surface = NearestOnTriangles::new(&[[a, b, c], [a, c, d]]);
        for i in 0..=1000 {
            let at = glam::Vec3::from(a).as_dvec3().lerp(glam::Vec3::from(c).as_dvec3(), f64::from(i) / 1000.0);
            let hit = surface.crossing_along(at + DVec3::Z * 0.3, DVec3::Z, 1.0, |_| true).unwrap();
            assert!((hit.point - at).length() < 1e-5, "{i}");
        }
        let twice = NearestOnTriangles::new(&[[a, b, c], [a, b, c]]);
        assert_eq!(twice.crossing_along([0.7, 0.7, 0.0].into(), DVec3::Z, 9.0, |_| true).unwrap().triangle, 0);
        assert_eq!(twice.crossing_along([0.7, 0.7, 0.0].into(), DVec3::Z, 9.0, |i| i > 0).unwrap().triangle, 1);
    }

    #[test]
    fn small_triangles_around_the_origin_are_met_too() {
        let mut all = triangles(200, 0.3);
        all.extend(triangles(200, 0.3).into_iter().map(|t| t.map(|p| p.map(|x| 1e-11 * x))));
        let surface = NearestOnTriangles::new(&all);
        assert!(surface.inner.is_some() && Bounds::from_points(&all[300]).high[0] < 1e-10);
        let hit = surface.crossing_along(DVec3::ZERO, DVec3::new(0.3, 0.5, 0.7), 1e-10, |_| true).unwrap();
        assert!(hit.triangle >= 200, "{hit:?}");
    }
}
