//! Corner coordinates and points of triangles, for the terms over candidate faces.

use glam::{DVec3, Vec3};

pub(super) fn corners(points: &[[f32; 3]], triangle: [u32; 3]) -> [[f32; 3]; 3] {
    triangle.map(|v| points[v as usize])
}

pub(super) fn corners_f64(points: &[[f32; 3]], triangle: [u32; 3]) -> [DVec3; 3] {
    corners(points, triangle).map(to_f64)
}

pub(super) fn barycenters(points: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<[f32; 3]> {
    let barycenter = |&triangle: &[u32; 3]| {
        let [a, b, c] = corners_f64(points, triangle);
        ((a + b + c) / 3.0).as_vec3().to_array()
    };
    triangles.iter().map(barycenter).collect()
}

pub(super) fn to_f64(point: [f32; 3]) -> DVec3 {
    Vec3::from(point).as_dvec3()
}

pub(super) fn distance2(a: [f32; 3], b: [f32; 3]) -> f64 {
    to_f64(a).distance_squared(to_f64(b))
}

/// Spreads `n` points evenly over a triangle, in a fixed pattern that starts at the barycenter (Roberts 2018).
pub(super) fn spread_points([a, b, c]: [DVec3; 3], n: usize) -> impl Iterator<Item = [f32; 3]> {
    (0..n).map(move |i| {
        let [mut u, mut v] = STEP.map(|step| (1.0 / 3.0 + step * i as f64).fract());
        if u + v > 1.0 {
            [u, v] = [1.0 - u, 1.0 - v];
        }
        (a + (b - a) * u + (c - a) * v).as_vec3().to_array()
    })
}

/// Steps of the pattern: inverse and squared inverse of the plastic number.
const STEP: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_lie_on_the_triangle_and_everywhere_on_it() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let found: Vec<[f32; 3]> = spread_points(corners, 400).collect();
        assert!(found.iter().all(|&[x, y, z]| x >= 0.0 && y >= 0.0 && x + y <= 1.0 && z == 0.0));
        let mean = found.iter().map(|&p| to_f64(p)).sum::<DVec3>() / 400.0;
        assert!(mean.distance(DVec3::new(1.0, 1.0, 0.0) / 3.0) < 0.01, "{mean}");
        let near_corners = corners.map(|corner| found.iter().filter(|&&p| to_f64(p).distance(corner) < 0.2).count());
        assert!(near_corners.iter().all(|n| (10..40).contains(n)), "{near_corners:?}");
    }
}
