//! Axis-parallel rays for winding numbers of points.

use glam::DVec2;

use crate::geometry::triangle::corners_f64;
use crate::spatial::{Bounds, NearestOnTriangles};

pub(super) struct Rays {
    tree: NearestOnTriangles,
    triangles: Vec<[[f32; 3]; 3]>,
    bounds: Bounds,
}

impl Rays {
    pub fn new(triangles: Vec<[[f32; 3]; 3]>) -> Self {
        let bounds = Bounds::from_points(triangles.as_flattened());
        Self { tree: NearestOnTriangles::new(&triangles), triangles, bounds }
    }

    /// Finds the triangles that the ray toward larger coordinates of `axis` crosses; `None` if it meets an edge.
    ///
    /// Each comes with a number: 1 if the ray leaves the triangle's body there, -1 if it enters.
    pub fn find_crossings(&self, from: [f32; 3], axis: usize) -> Option<Vec<(u32, i32)>> {
        // The ray, as a degenerate triangle from the point to the far side of the box.
        let mut end = from;
        end[axis] = self.bounds.high[axis].max(from[axis]);
        let mut near = Vec::new();
        self.tree.visit_touching(&[from, end, end], |triangle| near.push(triangle));
        near.sort_unstable();
        near.dedup();
        let mut crossed = Vec::new();
        for triangle in near {
            let crossing = crossing(self.triangles[triangle as usize], from, axis)?;
            crossed.extend(Some((triangle, crossing)).filter(|_| crossing != 0));
        }
        Some(crossed)
    }
}

fn crossing(corners: [[f32; 3]; 3], from: [f32; 3], axis: usize) -> Option<i32> {
    let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
    let flat = |p: [f32; 3]| DVec2::new(p[u].into(), p[v].into());
    let p = flat(from);
    let [a, b, c] = corners.map(flat).map(|corner| corner - p);
    let sides = [a.perp_dot(b), b.perp_dot(c), c.perp_dot(a)];
    let (any_left, any_right) = (sides.iter().any(|x| *x > 0.0), sides.iter().any(|x| *x < 0.0));
    // Signs of both kinds: the point projects outside the triangle.
    match (any_left && any_right, sides.contains(&0.0)) {
        (true, _) => return Some(0),
        (false, true) if any_left || any_right => return None,
        // A triangle parallel to the ray cannot be crossed.
        (false, true) => return Some(0),
        _ => {}
    }
    let points = corners_f64(corners);
    let total: f64 = sides.iter().sum();
    // The weight of a corner is the area of the triangle opposite to it.
    let height = points[2][axis] * sides[0] + points[0][axis] * sides[1] + points[1][axis] * sides[2];
    let is_above = height / total > f64::from(from[axis]);
    Some(if is_above { if any_left { 1 } else { -1 } } else { 0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    fn winding(rays: &Rays, p: [f32; 3]) -> [Option<i32>; 3] {
        [0, 1, 2].map(|axis| rays.find_crossings(p, axis).map(|crossed| crossed.iter().map(|(_, sign)| sign).sum()))
    }

    #[test]
    fn points_in_a_torus_are_told_from_others() {
        let torus = shapes::torus(40, 20, 2.0, 0.7);
        let corners = |face: &[u32; 3]| face.map(|v| torus.positions()[v as usize]);
        let rays = Rays::new(torus.faces().iter().map(corners).collect());
        for i in 0..300 {
            let [x, y, z] = [0.91, 1.73, 2.39].map(|step: f32| (i as f32 * step).sin());
            let p = [3.1 * x, 3.1 * y, 0.9 * z];
            let off = (p[0].hypot(p[1]) - 2.0).hypot(p[2]);
            if (off - 0.7).abs() > 0.03 {
                let found = winding(&rays, p);
                assert!(found.iter().flatten().all(|winding| *winding == i32::from(off < 0.7)), "{p:?} {found:?}");
                assert!(i == 0 || found.iter().all(Option::is_some), "{p:?}");
            }
        }
    }

    #[test]
    fn a_ray_through_a_corner_says_nothing() {
        let cube = shapes::cuboid([2.0; 3], 2);
        let corners = |face: &[u32; 3]| face.map(|v| cube.positions()[v as usize]);
        let rays = Rays::new(cube.faces().iter().map(corners).collect());
        let low = cube.positions()[0];
        assert_eq!(winding(&rays, low.map(|x| x + 1.0)), [None; 3]);
        assert_eq!(winding(&rays, [low[0] + 0.3, low[1] + 0.45, low[2] + 0.71]), [Some(1); 3]);
        assert_eq!(winding(&rays, low.map(|x| x + 9.0)), [Some(0); 3]);
    }
}
