//! Near triangles of points in a row: a triangle found for one of them is tried for all others, side by side.

use glam::DVec3;

use super::face_tree::{FaceTree, SearchCost};
use crate::geometry::triangle::corners_f64;
use crate::linalg::{Isa, Work};

/// Points that are tried side by side.
const ROW: usize = 64;
/// Tests of single triangles that take as long as one of all points of a row.
const COST: u32 = 4;

impl FaceTree<'_> {
    /// Searches as [`find_near`](Self::find_near) for each of many points, fast where a triangle is near several of them.
    ///
    /// Returns what it finds for each, and the number of tests; the tree must have triangles.
    ///
    /// ```
    /// # use neural_mesh_mesh as neural_mesh;
    /// use neural_mesh::spatial::FaceTree;
    /// let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// let tree = FaceTree::new(&positions, &[[0, 1, 2], [0, 1, 3]]);
    /// let points = [0.1, 0.2, 0.3].map(|x| [x, x, 0.01].into());
    /// assert_eq!(tree.find_near_in_row(&points, 0.5).0.len(), 3);
    /// ```
    pub fn find_near_in_row(&self, points: &[DVec3], enough: f64) -> (Vec<(u32, f64)>, SearchCost) {
        Isa::best().run(NearRow { tree: self, points, enough })
    }
}

/// A search for the nearest triangle of each point, or any at a squared distance of at most `enough`.
struct NearRow<'a, 'b> {
    tree: &'a FaceTree<'b>,
    points: &'a [DVec3],
    enough: f64,
}

impl Work for NearRow<'_, '_> {
    type Output = (Vec<(u32, f64)>, SearchCost);

    #[inline(always)]
    fn run(self) -> Self::Output {
        let NearRow { tree, points, enough } = self;
        let (mut found, mut cost, mut guess) = (vec![(0, f64::INFINITY); points.len()], SearchCost::default(), None);
        let scale2 = tree.scale * tree.scale;
        for (points, found) in points.chunks(ROW).zip(found.chunks_mut(ROW)) {
            let row = ScaledRow::new(points, tree.scale);
            let mut open = u64::MAX >> (ROW - points.len());
            while open != 0 {
                let i = open.trailing_zeros() as usize;
                let (face, distance2, tests) = tree.find_near_with_cost(points[i], guess, enough).unwrap_or_default();
                (guess, found[i]) = (Some(face), (face, distance2));
                cost = SearchCost { triangles: cost.triangles + tests.triangles, boxes: cost.boxes + tests.boxes };
                open &= open - 1;
                if distance2 > enough || open == 0 {
                    continue;
                }
                cost.triangles += COST;
                let heights2 = row.squared_heights_above(tree.corners(face));
                let mut tried = open;
                while tried != 0 {
                    let j = tried.trailing_zeros() as usize;
                    tried &= tried - 1;
                    if heights2[j] <= enough * scale2 {
                        found[j] = (face, heights2[j] / scale2);
                        open &= !(1 << j);
                    }
                }
            }
        }
        (found, cost)
    }
}

/// Scaled coordinates of the points of a row, by axis.
struct ScaledRow([[f64; ROW]; 3]);

impl ScaledRow {
    #[inline(always)]
    fn new(points: &[DVec3], scale: f64) -> Self {
        let mut row = [[0.0; ROW]; 3];
        for (i, point) in points.iter().enumerate() {
            (row[0][i], row[1][i], row[2][i]) = (point.x * scale, point.y * scale, point.z * scale);
        }
        Self(row)
    }

    /// Returns the squared heights over a triangle, infinite where a point does not fall on its inside.
    #[inline(always)]
    fn squared_heights_above(&self, corners: [[f32; 3]; 3]) -> [f64; ROW] {
        let [a, b, c] = corners_f64(corners);
        let normal = (b - a).cross(c - a);
        let (towards_b, towards_c, square) = ((c - a).cross(normal), normal.cross(b - a), normal.length_squared());
        let mut heights2 = [0.0; ROW];
        for (i, height2) in heights2.iter_mut().enumerate() {
            let [x, y, z] = [self.0[0][i] - a.x, self.0[1][i] - a.y, self.0[2][i] - a.z];
            let along = |axis: DVec3| x * axis.x + y * axis.y + z * axis.z;
            let (to_b, to_c, height) = (along(towards_b), along(towards_c), along(normal));
            let is_inside = (to_b > 0.0) & (to_c > 0.0) & (to_b + to_c < square);
            *height2 = if is_inside { height * height / square } else { f64::INFINITY };
        }
        heights2
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn each_point_gets_the_nearest_triangle_or_one_that_is_near_enough() {
        let (fine, coarse) = (shapes::wavy_sphere(4, 5.0), shapes::icosphere(2));
        let tree = FaceTree::new(coarse.positions(), coarse.faces());
        let points: Vec<DVec3> = fine.positions().iter().map(|p| glam::Vec3::from(*p).as_dvec3()).collect();
        for enough in [f64::NEG_INFINITY, 0.0, 1e-4, 0.01, 10.0] {
            for points in [&points[..], &points[..1], &points[..64], &points[..65]] {
                let (found, cost) = tree.find_near_in_row(points, enough);
                assert!(found.len() == points.len() && cost.total() > 0);
                for (&point, &(face, distance2)) in points.iter().zip(&found) {
                    let nearest = tree.nearest(point).unwrap();
                    let only = |other: u32| other == face;
                    let exact = tree.nearest_of(point, None, f64::INFINITY, only).unwrap().1;
                    assert!((distance2 - exact).abs() <= 1e-12 * exact.max(1e-3), "{distance2} {exact}");
                    assert!((face, distance2) == nearest || distance2 <= enough, "{distance2} {nearest:?}");
                }
            }
        }
        assert_eq!(tree.find_near_in_row(&[], 1.0).0.len(), 0);
    }
}
