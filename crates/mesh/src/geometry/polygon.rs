//! Triangulates one polygon in space without holes, by ear clipping in its plane.
//!
//! Every corner stays in some triangle, since dropping it would open a crack.

use glam::{DVec2, DVec3};

use super::polygon_grid::CornerGrid;

/// Largest number of tests, per corner and in total; after these, ears are clipped without tests.
const TESTS: (usize, usize) = (2048, 1 << 29);

/// Triangulates the simple polygon `corners` (n_corners x 3) into n_corners - 2 triangles of indices.
///
/// Exact for concave polygons; keeps the winding. A self-intersecting polygon gives some triangles over its corners.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::geometry::polygon::triangulate;
/// let dart = [[2.0, -1.0, 0.0], [0.5, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 0.0]];
/// assert_eq!(triangulate(&dart), [[1, 2, 3], [1, 3, 0]]);
/// ```
pub fn triangulate(corners: &[[f64; 3]]) -> Vec<[u32; 3]> {
    match corners.len() {
        0..=2 => Vec::new(),
        3 => vec![[0, 1, 2]],
        4 => split_quad(corners).to_vec(),
        _ => Ears::new(project(corners)).clip(),
    }
}

/// Splits a quad along the diagonal from corner 0, unless only with the other both triangles face one way.
fn split_quad(corners: &[[f64; 3]]) -> [[u32; 3]; 2] {
    let [a, b, c, d] = std::array::from_fn(|i| DVec3::from(corners[i]));
    let agree = |p: DVec3, q: DVec3, r: DVec3, s: DVec3| (q - p).cross(r - p).dot((r - p).cross(s - p)) >= 0.0;
    if !agree(a, b, c, d) && agree(b, c, d, a) { [[1, 2, 3], [1, 3, 0]] } else { [[0, 1, 2], [0, 2, 3]] }
}

/// Projects the corners to the plane of their largest projected area.
fn project(corners: &[[f64; 3]]) -> Vec<DVec2> {
    let first = DVec3::from(corners[0]);
    let spokes = || corners.iter().map(|&p| DVec3::from(p) - first);
    // Scaling first keeps products of huge or tiny coordinates within range.
    let extent = spokes().fold(0.0f64, |extent, p| extent.max(p.abs().max_element()));
    let scale = if extent > 0.0 && extent.is_finite() { 1.0 / extent } else { 1.0 };
    let normal: DVec3 = spokes().zip(spokes().skip(1)).map(|(p, q)| (p * scale).cross(q * scale)).sum();
    let size = normal.abs();
    spokes()
        .map(|p| p * scale)
        .map(|p| match size {
            s if s.z >= s.x && s.z >= s.y => DVec2::new(p.x, p.y * normal.z.signum()),
            s if s.y >= s.x => DVec2::new(p.z, p.x * normal.y.signum()),
            _ => DVec2::new(p.y, p.z * normal.x.signum()),
        })
        .collect()
}

struct Ears {
    points: Vec<DVec2>,
    next: Vec<u32>,
    previous: Vec<u32>,
    /// Corners that were reflex at the start; only they can be inside an ear.
    reflex: CornerGrid,
    alive: Vec<bool>,
    tests_left: usize,
}

impl Ears {
    fn new(points: Vec<DVec2>) -> Self {
        let n = points.len() as u32;
        let next: Vec<u32> = (1..n).chain([0]).collect();
        let previous: Vec<u32> = [n - 1].into_iter().chain(0..n - 1).collect();
        let (alive, tests_left) = (vec![true; points.len()], (TESTS.0 * points.len()).min(TESTS.1));
        let mut ears = Self { reflex: CornerGrid::new(&points, &[]), points, next, previous, alive, tests_left };
        let reflex: Vec<u32> = (0..n).filter(|&corner| ears.turn(corner) <= 0.0).collect();
        ears.reflex = CornerGrid::new(&ears.points, &reflex);
        ears
    }

    fn turn(&self, corner: u32) -> f64 {
        let [a, b, c] = self.ear(corner).map(|i| self.points[i as usize]);
        (b - a).perp_dot(c - a)
    }

    fn ear(&self, corner: u32) -> [u32; 3] {
        [self.previous[corner as usize], corner, self.next[corner as usize]]
    }

    fn clip(mut self) -> Vec<[u32; 3]> {
        let n_triangles = self.points.len() - 2;
        let mut triangles = Vec::with_capacity(n_triangles);
        while triangles.len() < n_triangles {
            let before = triangles.len();
            self.clip_round(n_triangles, &mut triangles);
            if triangles.len() == before {
                let flattest = self.ring().min_by(|&a, &b| self.turn(a).abs().total_cmp(&self.turn(b).abs()));
                triangles.extend(flattest.map(|corner| self.cut(corner)));
            }
        }
        triangles
    }

    fn ring(&self) -> impl Iterator<Item = u32> {
        (0..self.points.len() as u32).filter(|&corner| self.alive[corner as usize])
    }

    fn clip_round(&mut self, n_triangles: usize, triangles: &mut Vec<[u32; 3]>) {
        let mut queue: Vec<u32> = self.ring().collect();
        let mut turn = vec![0; self.points.len()];
        queue.iter().enumerate().for_each(|(i, &corner)| turn[corner as usize] = i);
        let mut i = 0;
        while i < queue.len() && triangles.len() < n_triangles {
            let corner = queue[i];
            if self.alive[corner as usize] && turn[corner as usize] == i && self.is_ear(corner) {
                let ear @ [before, _, after] = self.cut(corner);
                triangles.push(ear);
                for neighbour in [before, after] {
                    turn[neighbour as usize] = queue.len();
                    queue.push(neighbour);
                }
            }
            i += 1;
        }
    }

    /// Returns whether `corner` is convex and no other corner is in its triangle.
    fn is_ear(&mut self, corner: u32) -> bool {
        if self.tests_left == 0 {
            return true;
        }
        self.tests_left -= 1;
        let ear = self.ear(corner);
        let [a, b, c] = ear.map(|i| self.points[i as usize]);
        if (b - a).perp_dot(c - a) <= 0.0 {
            return false;
        }
        let (blocked, n_tests) = self.reflex.any_near([a, b, c], |other| {
            let p = self.points[other as usize];
            let sides = [(b - a).perp_dot(p - a), (c - b).perp_dot(p - b), (a - c).perp_dot(p - c)];
            let inside = sides.into_iter().all(|side| side >= 0.0);
            inside && self.alive[other as usize] && !ear.contains(&other) && ![a, b, c].contains(&p)
        });
        self.tests_left = self.tests_left.saturating_sub(n_tests);
        !blocked
    }

    fn cut(&mut self, corner: u32) -> [u32; 3] {
        let ear @ [before, _, after] = self.ear(corner);
        self.next[before as usize] = after;
        self.previous[after as usize] = before;
        self.alive[corner as usize] = false;
        ear
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::triangle::area_normal_f64;
    use proptest::prelude::*;

    fn normals(corners: &[[f64; 3]]) -> Vec<DVec3> {
        let normal = |triangle: [u32; 3]| area_normal_f64(triangle.map(|corner| corners[corner as usize].into()));
        triangulate(corners).into_iter().map(normal).collect()
    }

    fn covers(corners: &[[f64; 3]]) -> bool {
        let normals = normals(corners);
        let total: DVec3 = normals.iter().sum();
        let area: f64 = normals.iter().map(|normal| normal.length()).sum();
        normals.len() == corners.len() - 2 && (area - total.length()).abs() <= 1e-9 * area
    }

    fn spin(points: impl IntoIterator<Item = [f64; 2]>) -> Vec<[f64; 3]> {
        let spin = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.4, -1.1, 2.0);
        points.into_iter().map(|[x, y]| (spin * DVec3::new(x, y, 3.0)).to_array()).collect()
    }

    proptest! {
        #[test]
        fn star_shaped_polygons_are_covered(radii in prop::collection::vec(0.1f64..5.0, 4..60), clockwise in any::<bool>()) {
            let turn = if clockwise { -1.0 } else { 1.0 } * std::f64::consts::TAU / radii.len() as f64;
            let corner = |(i, r): (usize, &f64)| [r * (turn * i as f64).cos(), r * (turn * i as f64).sin()];
            let corners = spin(radii.iter().enumerate().map(corner));
            prop_assert!(covers(&corners));
        }

        #[test]
        fn any_corners_give_triangles(corners in prop::collection::vec(prop::array::uniform3(-2i8..2), 0..20)) {
            let corners: Vec<_> = corners.into_iter().map(|p| p.map(f64::from)).collect();
            let triangles = triangulate(&corners);
            prop_assert_eq!(triangles.len(), corners.len().saturating_sub(2));
            prop_assert!(triangles.into_iter().flatten().all(|corner| (corner as usize) < corners.len()));
        }
    }

    #[test]
    fn concave_quads_split_at_their_reflex_corner() {
        for turn in 0..4 {
            let mut dart = [[0.0, 0.0], [2.0, -1.0], [0.5, 0.0], [2.0, 1.0]];
            dart.rotate_left(turn);
            assert!(covers(&spin(dart)), "{turn}");
        }
    }

    #[test]
    fn collinear_corners_stay() {
        let corners = spin([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 2.0], [0.0, 2.0], [0.0, 1.0]]);
        assert!(covers(&corners));
        let mut used: Vec<u32> = triangulate(&corners).into_iter().flatten().collect();
        used.sort_unstable();
        used.dedup();
        assert_eq!(used.len(), corners.len());
    }

    #[test]
    fn a_comb_of_many_teeth_is_covered() {
        let tooth = |i: usize| [[i as f64, 0.0], [i as f64 + 0.5, 10.0]];
        let corners = spin((0..1000).flat_map(tooth).chain([[1000.0, -1.0], [-1.0, -1.0]]).rev());
        assert!(covers(&corners));
    }

    #[test]
    fn a_spiral_is_covered() {
        let arm = |(i, width): (usize, f64)| {
            let angle = 0.2 * i as f64;
            [(angle + width) * angle.cos(), (angle + width) * angle.sin()]
        };
        let corners = spin((40..400).map(|i| (i, 0.0)).chain((40..400).rev().map(|i| (i, 2.0))).map(arm));
        assert!(covers(&corners));
    }

    #[test]
    fn huge_and_tiny_polygons_are_covered() {
        for scale in [1e-200, 1e200] {
            let dent = spin([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 0.5], [0.0, 2.0]]);
            let scaled: Vec<_> = dent.iter().map(|p| p.map(|x| x * scale)).collect();
            assert_eq!(triangulate(&scaled), triangulate(&dent));
        }
    }

    #[test]
    fn time_is_bounded_on_a_line() {
        let corners = spin((0..1_000u64).map(|i| [(i * 7919 % 20_011) as f64, 0.0]));
        assert_eq!(triangulate(&corners).len(), corners.len() - 2);
    }

    #[test]
    fn time_is_bounded_where_no_ear_is_found() {
        // A zigzag that crosses itself everywhere.
        let corners = spin((0..1_000u64).map(|i| [(i * 7919 % 1000) as f64, (i * 104_729 % 997) as f64]));
        assert_eq!(triangulate(&corners).len(), corners.len() - 2);
    }
}
