//! Coordinates in the frame of a triangle.

use glam::Vec3;

// Number added to divisors against division by zero, in units of the triangle.
const LEAST: f32 = 1e-6;
// Limit of barycentric coordinates, which grow without bound for thin triangles.
const FARTHEST: f32 = 5.0;
// Limit of coordinates in units of the triangle.
const LARGEST: f32 = 1e9;

/// A frame at a triangle's barycenter: x along the first edge, z along the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalFrame {
    barycenter: Vec3,
    per_unit: f32,
    corners: [Vec3; 3],
    axes: [Vec3; 3],
    area: f32,
}

impl LocalFrame {
    /// Makes the frame of a triangle.
    pub fn new(corners: [[f32; 3]; 3]) -> Self {
        let corners = corners.map(Vec3::from_array);
        let barycenter = (corners[0] + corners[1] + corners[2]) / 3.0;
        let radius = corners.iter().map(|corner| corner.distance(barycenter)).sum::<f32>() / 3.0;
        // The unit is the mean distance of the corners; without area, coordinates along missing axes are zero.
        let per_unit = if radius > f32::MIN_POSITIVE { 1.0 / radius } else { 0.0 };
        let corners = corners.map(|corner| (corner - barycenter) * per_unit);
        let area_normal = 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let area = area_normal.length() + LEAST;
        let z = area_normal / area;
        let unit = |v: Vec3| v / (v.length() + LEAST);
        let x = unit(corners[1] - corners[0]);
        Self { barycenter, per_unit, corners, axes: [x, unit(z.cross(x)), z], area }
    }

    /// Returns x, y, z in the frame and the barycentric coordinates u, v, w, the latter limited to -5..=5.
    pub fn coordinates(&self, point: [f32; 3]) -> [f32; 6] {
        let p = (Vec3::from_array(point) - self.barycenter) * self.per_unit;
        // Products stay finite for nearly vanishing triangles.
        let p = p.clamp(Vec3::splat(-LARGEST), Vec3::splat(LARGEST));
        let [x, y, z] = self.axes;
        let corners = self.corners.map(|corner| corner - p);
        // The component along z vanishes in the product with z.
        let share = |a: Vec3, b: Vec3| ((0.5 * z.dot(a.cross(b)) + LEAST / 3.0) / self.area).clamp(-FARTHEST, FARTHEST);
        let [a, b, c] = corners;
        [x.dot(p), y.dot(p), z.dot(p), share(b, c), share(c, a), share(a, b)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moving_turning_and_scaling_change_nothing() {
        let corners = [[0.1, 0.2, 0.3], [1.4, 0.2, 0.1], [0.3, 1.2, 0.7]];
        let point = [0.9, -0.4, 0.6];
        let moved = |[x, y, z]: [f32; 3]| [5.0 - 3.0 * y, 3.0 * x + 1.0, 3.0 * z - 2.0];
        let here = LocalFrame::new(corners).coordinates(point);
        let there = LocalFrame::new(corners.map(moved)).coordinates(moved(point));
        assert!(here.iter().zip(there).all(|(a, b)| (a - b).abs() < 1e-5), "{here:?} {there:?}");
        assert!(here[1] < 0.0 && here[3] + here[4] + here[5] > 0.999);
        let frame = LocalFrame::new([[0.0; 3], [3.0, 0.0, 0.0], [0.0, 3.0, 0.0]]);
        let [_, _, z, u, v, w] = frame.coordinates([1.0, 1.0, 0.0]);
        assert!(z.abs() < 1e-6 && [u, v, w].iter().all(|x| (x - 1.0 / 3.0).abs() < 1e-5));
    }

    #[test]
    fn triangles_without_area_have_finite_coordinates() {
        for corners in [[[1.0; 3]; 3], [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], [[0.0; 3], [1e-36; 3], [0.0; 3]]] {
            let found = LocalFrame::new(corners).coordinates([7.0, 1.0, -3.0]);
            assert!(found.iter().all(|x| x.is_finite()), "{found:?}");
        }
    }
}
