//! Random points on candidate triangles.

use super::patches::corners;
use glam::DVec3;
use neural_mesh::geometry::triangle::area_normal_f64;
use neural_mesh::train::random::uniform;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

/// A point on a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleSample {
    /// Index of the triangle.
    pub triangle: u32,
    /// Position.
    pub point: [f32; 3],
}

/// Draws `n` points on triangles by area times weight; none if these products sum to 0.
///
/// # Shapes
/// - `weights`: n_triangles, non-negative
pub fn triangle_samples(
    vertices: &[[f32; 3]],
    triangles: &[[u32; 3]],
    weights: &[f32],
    n: usize,
    seed: u64,
) -> Vec<TriangleSample> {
    let of = |&triangle: &[u32; 3]| corners(vertices, triangle).map(|p| DVec3::from_array(p.map(f64::from)));
    let mut sum = 0.0;
    let mut up_to = Vec::with_capacity(triangles.len());
    for (triangle, &weight) in triangles.iter().zip(weights) {
        sum += area_normal_f64(of(triangle)).length() * f64::from(weight);
        up_to.push(sum);
    }
    if sum <= 0.0 {
        return Vec::new();
    }
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut uniform = || uniform(&mut random);
    let mut draw = |_| {
        let reach = uniform() * sum;
        let triangle = up_to.partition_point(|&up_to| up_to <= reach).min(triangles.len() - 1);
        let [a, b, c] = of(&triangles[triangle]);
        let (root, share) = (uniform().sqrt(), uniform());
        let point = a * (1.0 - root) + b * (root * (1.0 - share)) + c * (root * share);
        TriangleSample { triangle: triangle as u32, point: point.as_vec3().to_array() }
    };
    (0..n).map(&mut draw).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_get_samples_by_area_and_weight() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 3.0]];
        // Areas are 1 : 3, weights 3 : 2.
        let samples = triangle_samples(&points, &[[0, 1, 2], [0, 1, 3]], &[0.75, 0.5], 3000, 1);
        let on_first = samples.iter().filter(|sample| sample.triangle == 0).count();
        assert!((900..1100).contains(&on_first), "{on_first}");
        assert!(triangle_samples(&points, &[[0, 1, 1]], &[1.0], 5, 0).is_empty());
        assert!(triangle_samples(&points, &[], &[], 5, 0).is_empty());
    }
}
