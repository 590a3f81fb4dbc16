//! Expected distance of the triangles from the surface.

use super::TriangleSample;
use glam::DVec3;
use neural_mesh::loss::Term;
use neural_mesh::spatial::nearest_to;

/// A surface point with its normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Position.
    pub point: [f32; 3],
    /// Unit normal.
    pub normal: [f32; 3],
}

/// Computes `mean over samples of p d` with the distance d from the tangent plane of the nearest surface point.
///
/// # Shapes
/// - `samples`: n, drawn by area; p is the probability of their triangle
/// - `length`: unit of length, about the size of the patch, above 0
/// - returns the mean in this unit and its gradient by p
pub fn triangles_to_surface(
    surface: &[SurfacePoint],
    samples: &[TriangleSample],
    probabilities: &[f32],
    length: f64,
) -> Term {
    let mut gradient = vec![0.0f64; probabilities.len()];
    if surface.is_empty() {
        return Term::zero(probabilities.len());
    }
    let points: Vec<[f32; 3]> = surface.iter().map(|at| at.point).collect();
    let queries: Vec<[f32; 3]> = samples.iter().map(|sample| sample.point).collect();
    let wide = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let mut sum = 0.0;
    for (sample, near) in samples.iter().zip(nearest_to(&points, &queries, 1)) {
        let near = surface[near as usize];
        let distance = (wide(sample.point) - wide(near.point)).dot(wide(near.normal)).abs() / length;
        sum += distance * f64::from(probabilities[sample.triangle as usize]);
        gradient[sample.triangle as usize] += distance;
    }
    Term::mean(sum, &gradient, samples.len())
}

#[cfg(test)]
mod tests {
    use super::super::test_golden::{assert_gradient, probabilities, samples, surface};
    use super::*;

    #[test]
    fn agrees_with_numpy_and_with_differences() {
        let p = probabilities();
        let loss = |p: &[f32]| triangles_to_surface(&surface(), &samples(), p, 1.5);
        let value = loss(&p).value;
        assert!((value - 0.0901639792935957).abs() < 1e-5, "{value}");
        assert_gradient(&p, loss);
    }

    #[test]
    fn nothing_is_fine() {
        assert_eq!(triangles_to_surface(&[], &samples(), &probabilities(), 1.0).value, 0.0);
        assert_eq!(triangles_to_surface(&surface(), &[], &[], 1.0), Term::zero(0));
    }
}
