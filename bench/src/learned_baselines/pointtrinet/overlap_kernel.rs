//! The overlap loss.

use super::TriangleSample;
use super::patches::corners;
use glam::DVec3;
use neural_mesh::geometry::triangle::area_normal_f64;
use neural_mesh::loss::Term;
use neural_mesh::parallel;

// Height of the kernel as a fraction of the distance to the nearest edge.
const HEIGHT: f64 = 0.5;
const LEAST: f64 = 1e-8;

/// Computes `mean over samples of (s - 1)^2 + (m - 1)^2` with sum s and maximum m of `p_t k_t` over all triangles.
///
/// # Shapes
/// - `samples`: n, drawn by area times probability; treated as constant
/// - returns the mean and its gradient by the probabilities
pub fn overlap_kernel(
    samples: &[TriangleSample],
    vertices: &[[f32; 3]],
    triangles: &[[u32; 3]],
    probabilities: &[f32],
) -> Term {
    let zones: Vec<TrianglePrism> =
        triangles.iter().map(|&triangle| TrianglePrism::new(corners(vertices, triangle))).collect();
    let of_sample = |sample: &TriangleSample| -> (f64, Vec<(u32, f64)>) {
        let p = DVec3::from_array(sample.point.map(f64::from));
        let over: Vec<(u32, f64)> =
            zones.iter().zip(0..).map(|(zone, t)| (t, zone.kernel(p))).filter(|(_, k)| *k > 0.0).collect();
        sample_loss(&over, probabilities)
    };
    let each = parallel::map(samples.len(), 16, |i| of_sample(&samples[i]));
    let mut gradient = vec![0.0f64; probabilities.len()];
    for (triangle, slope) in each.iter().flat_map(|(_, slopes)| slopes) {
        gradient[*triangle as usize] += slope;
    }
    Term::mean(each.iter().map(|(value, _)| value).sum(), &gradient, samples.len())
}

fn sample_loss(over: &[(u32, f64)], probabilities: &[f32]) -> (f64, Vec<(u32, f64)>) {
    let weighted = |&(t, k): &(u32, f64)| k * f64::from(probabilities[t as usize]);
    let sum: f64 = over.iter().map(weighted).sum();
    let mut largest = (0.0, None);
    for (place, of) in over.iter().enumerate() {
        if weighted(of) > largest.0 {
            largest = (weighted(of), Some(place));
        }
    }
    let slope = |(place, &(t, k)): (usize, &(u32, f64))| {
        let of_largest = if largest.1 == Some(place) { largest.0 - 1.0 } else { 0.0 };
        (t, 2.0 * k * (sum - 1.0 + of_largest))
    };
    ((sum - 1.0).powi(2) + (largest.0 - 1.0).powi(2), over.iter().enumerate().map(slope).collect())
}

// The normal and the inward normals of the edges, if the triangle has area.
struct TrianglePrism {
    corners: [DVec3; 3],
    sides: Option<[DVec3; 4]>,
}

impl TrianglePrism {
    fn new(corners: [[f32; 3]; 3]) -> Self {
        let corners = corners.map(|corner| DVec3::from_array(corner.map(f64::from)));
        let normal = area_normal_f64(corners).try_normalize();
        let inward = |normal: DVec3, i: usize| normal.cross(corners[(i + 1) % 3] - corners[i]).normalize_or_zero();
        let sides = normal.map(|normal| [normal, inward(normal, 0), inward(normal, 1), inward(normal, 2)]);
        Self { corners, sides }
    }

    fn kernel(&self, p: DVec3) -> f64 {
        let Some([normal, sides @ ..]) = self.sides else { return 0.0 };
        let to_edge = |i: usize| sides[i].dot(p - self.corners[i]);
        let inside = to_edge(0).min(to_edge(1)).min(to_edge(2));
        if inside < 0.0 {
            return 0.0;
        }
        // The kernel is `k_t = max(0, 1 - h / (0.5 e))` at height h and distance e from the nearest edge.
        let height = normal.dot(p - self.corners[0]).abs();
        (1.0 - height / (HEIGHT * inside + LEAST)).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_golden::{assert_gradient, probabilities, samples, triangles, vertices};
    use super::*;

    #[test]
    fn agrees_with_numpy_and_with_differences() {
        let p = probabilities();
        let loss = |p: &[f32]| overlap_kernel(&samples(), &vertices(), &triangles(), p);
        let value = loss(&p).value;
        assert!((value - 0.46370482291922627).abs() < 1e-4, "{value}");
        assert_gradient(&p, loss);
    }

    #[test]
    fn the_kernel_falls_with_the_height_the_sooner_the_nearer_the_edge() {
        let zone = TrianglePrism::new([[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]);
        let at = |x: f64, y: f64, z: f64| zone.kernel(DVec3::new(x, y, z));
        assert_eq!([at(1.0, 1.0, 0.0), at(-0.1, 1.0, 0.0)], [1.0, 0.0]);
        assert!((at(1.0, 1.0, 0.25) - 0.5).abs() < 1e-6 && (at(0.5, 1.0, -0.2) - 0.2).abs() < 1e-6);
        assert_eq!(TrianglePrism::new([[1.0; 3]; 3]).kernel(DVec3::ONE), 0.0);
    }

    #[test]
    fn a_triangle_over_another_costs_and_one_alone_does_not() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let inside = TriangleSample { triangle: 0, point: [0.8, 0.2, 0.0] };
        let alone = overlap_kernel(&[inside], &points, &[[0, 1, 2]], &[0.75]);
        assert!((alone.value - 2.0 * 0.0625).abs() < 1e-6 && (alone.gradient[0] + 1.0).abs() < 1e-6);
        let sample = TriangleSample { triangle: 0, point: [0.5, 0.25, 0.0] };
        let loss = |p: [f32; 2]| overlap_kernel(&[sample], &points, &[[0, 1, 2], [0, 1, 3]], &p).value;
        assert_eq!([loss([1.0, 0.0]), loss([1.0, 1.0])].map(|x| (x * 1e6).round() / 1e6), [0.0, 1.0]);
    }
}
