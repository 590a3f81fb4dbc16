//! Planes through the neighbours of points.

use crate::geometry::eigenvalues;
use crate::parallel;
use crate::spatial::nearest_to;
use glam::{DVec3, Vec3};

/// Plane of least squares through points.
#[derive(Clone, Copy, Debug)]
pub(super) struct FittedPlane {
    pub centre: DVec3,
    /// Unit vector of either sign; zero if the points lie on a line.
    pub normal: DVec3,
    /// Root mean square distances from the centre along the three axes, ascending.
    pub spread: [f64; 3],
}

/// Fits a plane to points with weights, which must not all be 0.
pub(super) fn fit_plane(points: impl Iterator<Item = (DVec3, f64)> + Clone) -> FittedPlane {
    let add = |(sum, total): (DVec3, f64), (p, weight): (DVec3, f64)| (sum + weight * p, total + weight);
    let (sum, total) = points.clone().fold((DVec3::ZERO, 0.0), add);
    let centre = sum / total;
    let mut covariance = [0.0; 6];
    for (p, weight) in points {
        let d = p - centre;
        let terms = [d.x * d.x, d.x * d.y, d.x * d.z, d.y * d.y, d.y * d.z, d.z * d.z];
        covariance.iter_mut().zip(terms).for_each(|(sum, term)| *sum += weight * term / total);
    }
    let values = eigenvalues(covariance);
    FittedPlane { centre, normal: eigenvector(covariance, values[0]), spread: values.map(|v| v.max(0.0).sqrt()) }
}

/// Returns the unit eigenvector of a single eigenvalue of a symmetric matrix, zero for a double one.
fn eigenvector([xx, xy, xz, yy, yz, zz]: [f64; 6], value: f64) -> DVec3 {
    // It is orthogonal to all rows of the matrix less the eigenvalue; the longest product of two rows is the most exact.
    let rows = [DVec3::new(xx - value, xy, xz), DVec3::new(xy, yy - value, yz), DVec3::new(xz, yz, zz - value)];
    let products = [rows[0].cross(rows[1]), rows[1].cross(rows[2]), rows[2].cross(rows[0])];
    let longest = products.into_iter().max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
    longest.unwrap_or_default().normalize_or_zero()
}

/// Returns two unit vectors orthogonal to each other and to a unit vector.
pub(super) fn tangents(normal: DVec3) -> [DVec3; 2] {
    normal.any_orthonormal_pair().into()
}

/// Returns the normal of the plane through the `k` nearest points of each point, n unit vectors of either sign.
pub(super) fn plane_normals(points: &[[f32; 3]], k: usize) -> Vec<DVec3> {
    let nearest = nearest_to(points, points, k);
    let normal = |some: &[u32]| fit_plane(some.iter().map(|&v| (point(points, v), 1.0))).normal;
    let k = k.min(points.len());
    parallel::map(points.len(), 64, |v| normal(&nearest[v * k..][..k]))
}

pub(super) fn point(points: &[[f32; 3]], v: u32) -> DVec3 {
    Vec3::from(points[v as usize]).as_dvec3()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_is_found_whatever_its_direction() {
        for normal in [DVec3::X, DVec3::new(1.0, 2.0, 3.0), DVec3::new(-1.0, 1e-3, 0.0)].map(DVec3::normalize) {
            let [x, y] = tangents(normal);
            assert!(x.dot(normal).abs() + y.dot(normal).abs() + x.dot(y).abs() < 1e-12);
            let grid = (0..25).map(|i| (7.0 * normal + f64::from(i % 5) * x + 0.5 * f64::from(i / 5) * y, 1.0));
            let plane = fit_plane(grid);
            assert!(plane.normal.dot(normal).abs() > 1.0 - 1e-9, "{plane:?}");
            assert!((plane.centre.dot(normal) - 7.0).abs() < 1e-9 && plane.spread[0] < 1e-6);
        }
    }

    #[test]
    fn points_on_a_line_have_no_normal() {
        let line: Vec<[f32; 3]> = (0..9).map(|i| [i as f32, 0.0, 0.0]).collect();
        assert!(plane_normals(&line, 4).iter().all(|&normal| normal == DVec3::ZERO));
    }
}
