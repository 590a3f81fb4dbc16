//! A ball of fixed radius over points with normals.

use glam::DVec3;

use neural_mesh::spatial::PointGrid;

// A point inside the ball by less than this fraction of the radius counts as on its surface.
const ON_THE_BALL: f64 = 1e-4;

pub(super) struct Ball<'a> {
    points: &'a [DVec3],
    normals: &'a [DVec3],
    radius: f64,
    grid: PointGrid,
}

impl<'a> Ball<'a> {
    pub(super) fn new(points: &'a [DVec3], normals: &'a [DVec3], radius: f64) -> Self {
        let rows: Vec<[f64; 3]> = points.iter().map(DVec3::to_array).collect();
        Self { points, normals, radius, grid: PointGrid::new(&rows, 2.0 * radius) }
    }

    pub(super) fn point(&self, v: u32) -> DVec3 {
        self.points[v as usize]
    }

    pub(super) fn points_near(&self, p: DVec3) -> Vec<u32> {
        self.grid.find_within(p.to_array(), 2.0 * self.radius)
    }

    pub(super) fn center(&self, face: [u32; 3]) -> Option<DVec3> {
        let [a, b, c] = face.map(|v| self.point(v));
        let (ab, ac) = (b - a, c - a);
        let normal = ab.cross(ac);
        // The ball rests on the face's front side, so no corner's normal may point to the back.
        let has_no_side = normal == DVec3::ZERO || !normal.is_finite();
        if has_no_side || face.iter().any(|&v| normal.dot(self.normals[v as usize]) < 0.0) {
            return None;
        }
        let to_middle = (normal.cross(ab) * ac.length_squared() + ac.cross(normal) * ab.length_squared())
            / (2.0 * normal.length_squared());
        let height2 = self.radius * self.radius - to_middle.length_squared();
        (height2 >= 0.0).then(|| a + to_middle + normal.normalize_or_zero() * height2.sqrt())
    }

    pub(super) fn is_empty(&self, center: DVec3, face: [u32; 3], near: &[u32]) -> bool {
        let inside = (1.0 - ON_THE_BALL) * self.radius;
        let is_inside = |&v: &u32| self.point(v).distance_squared(center) < inside * inside && !face.contains(&v);
        !near.iter().any(is_inside)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ball_rests_at_its_radius_from_three_points() {
        let points = [DVec3::ZERO, DVec3::X, DVec3::new(0.2, 0.9, 0.3)];
        let normals = [DVec3::Z; 3];
        let ball = Ball::new(&points, &normals, 0.8);
        let center = ball.center([0, 1, 2]).unwrap();
        points.iter().for_each(|p| assert!((p.distance(center) - 0.8).abs() < 1e-12));
        assert!(center.z > 0.0);
        assert_eq!(ball.center([0, 2, 1]), None);
        assert_eq!(Ball::new(&points, &normals, 0.4).center([0, 1, 2]), None);
    }
}
