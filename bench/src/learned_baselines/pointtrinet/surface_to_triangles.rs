//! Expected distance of the surface from the triangles.

use super::patches::corners;
use glam::Vec3;
use neural_mesh::geometry::triangle::nearest_point;
use neural_mesh::loss::Term;
use neural_mesh::parallel;

// Nearest triangles considered for a surface point.
const NEAREST: usize = 32;

/// Computes the expected distance of surface points from the nearest kept triangle, each kept with its probability.
///
/// # Shapes
/// - `surface`: n x 3; `probabilities`: n_triangles
/// - `length`: unit of length, about the size of the patch, above 0
/// - returns the mean in this unit and its gradient by the probabilities
pub fn surface_to_triangles(
    surface: &[[f32; 3]],
    vertices: &[[f32; 3]],
    triangles: &[[u32; 3]],
    probabilities: &[f32],
    length: f64,
) -> Term {
    let of_point =
        |i: usize| expected_distance(&nearest_triangles(surface[i], vertices, triangles), probabilities, length);
    let each = parallel::map(surface.len(), 16, of_point);
    let mut gradient = vec![0.0f64; probabilities.len()];
    for (triangle, slope) in each.iter().flat_map(|(_, slopes)| slopes) {
        gradient[*triangle as usize] += slope / length;
    }
    Term::mean(each.iter().map(|(value, _)| value / length).sum(), &gradient, surface.len())
}

fn nearest_triangles(point: [f32; 3], vertices: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<(f32, u32)> {
    let p = Vec3::from_array(point);
    let distance =
        |&triangle: &[u32; 3]| nearest_point(p, corners(vertices, triangle).map(Vec3::from_array)).distance(p);
    let mut all: Vec<(f32, u32)> = triangles.iter().map(distance).zip(0..).collect();
    let before = |a: &(f32, u32), b: &(f32, u32)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
    if all.len() > NEAREST {
        all.select_nth_unstable_by(NEAREST, before);
        all.truncate(NEAREST);
    }
    all.sort_unstable_by(before);
    all
}

fn expected_distance(nearest: &[(f32, u32)], probabilities: &[f32], length: f64) -> (f64, Vec<(u32, f64)>) {
    let p = |triangle: u32| f64::from(probabilities[triangle as usize]);
    let mut slopes: Vec<(u32, f64)> = Vec::with_capacity(nearest.len());
    // `sum over k of d_k p_k product over j < k of (1 - p_j)` is `e' = p d + (1 - p) e` from the farthest triangle on;
    // `length` counts where no triangle is kept.
    let mut beyond = length;
    for &(distance, triangle) in nearest.iter().rev() {
        slopes.push((triangle, f64::from(distance) - beyond));
        beyond = p(triangle) * f64::from(distance) + (1.0 - p(triangle)) * beyond;
    }
    let mut none_before = 1.0;
    for (triangle, slope) in slopes.iter_mut().rev() {
        *slope *= none_before;
        none_before *= 1.0 - p(*triangle);
    }
    (beyond, slopes)
}

#[cfg(test)]
mod tests {
    use super::super::test_golden::{assert_gradient, probabilities, triangles, vertices};
    use super::*;

    #[test]
    fn agrees_with_numpy_and_with_differences() {
        let (vertices, triangles, p) = (vertices(), triangles(), probabilities());
        let loss = |p: &[f32]| surface_to_triangles(&vertices[..5], &vertices, &triangles[..9], p, 1.5);
        let value = surface_to_triangles(&[[0.3, -0.2, 0.6], [1.0, 1.0, 1.0]], &vertices, &triangles, &p, 1.5).value;
        assert!((value - 0.23174488044220487).abs() < 1e-5, "{value}");
        assert_gradient(&p[..9], loss);
    }

    #[test]
    fn far_triangles_do_not_count() {
        let vertices: Vec<[f32; 3]> =
            (0..40).flat_map(|i| [[0.0, 0.0, i as f32], [1.0, 0.0, i as f32], [0.0, 1.0, i as f32]]).collect();
        let triangles: Vec<[u32; 3]> = (0..40).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let term = surface_to_triangles(&[[0.2, 0.2, -1.0]], &vertices, &triangles, &[0.01; 40], 100.0);
        assert!(term.gradient[31] < 0.0 && term.gradient[32] == 0.0);
        assert_eq!(surface_to_triangles(&[[0.0; 3]], &[], &[], &[], 3.0).value, 1.0);
    }
}
