//! Ball pivoting: triangles where a ball rests on three points (Bernardini et al. 1999).

mod ball;
mod rolling;
mod sheet;

use glam::DVec3;

use super::points::to_double;
use ball::Ball;
use neural_mesh::spatial::nearest_neighbours;
use rolling::{add_face, find_seed, reopen_edges, roll};
use sheet::Sheet;

// Multiples of the average nearest-point distance, as in Open3D and MeshLab.
const RADII: [f64; 4] = [1.0, 1.5, 2.0, 4.0];

/// Meshes points by balls of several sizes; no edge has more than two faces.
///
/// # Shapes
/// - `points`, `normals`: n x 3, finite; normals of any length
/// - returns n_faces x 3
///
/// # Panics
/// If there is not one normal per point.
pub fn ball_pivoting(points: &[[f32; 3]], normals: &[[f32; 3]]) -> Vec<[u32; 3]> {
    assert_eq!(points.len(), normals.len(), "one normal per point");
    let [points, normals] = [points, normals].map(to_double);
    let mut sheet = Sheet::new(points.len());
    let Some(spacing) = average_spacing(&points) else { return Vec::new() };
    for radius in RADII.map(|multiple| multiple * spacing) {
        let ball = Ball::new(&points, &normals, radius);
        // Each ball first rolls over edges that smaller balls left open, then starts from new seeds.
        let front = reopen_edges(&ball, &sheet);
        roll(&ball, &mut sheet, front);
        for v in 0..points.len() as u32 {
            if let Some(seed) = find_seed(&ball, &sheet, v) {
                let front = add_face(&mut sheet, seed);
                roll(&ball, &mut sheet, front);
            }
        }
    }
    sheet.faces
}

fn average_spacing(points: &[DVec3]) -> Option<f64> {
    let single: Vec<[f32; 3]> = points.iter().map(|p| p.as_vec3().to_array()).collect();
    let nearest = nearest_neighbours(&single, 1);
    let sum: f64 = nearest.iter().zip(points).map(|(&at, p)| p.distance(points[at as usize])).sum();
    Some(sum / nearest.len() as f64).filter(|spacing| *spacing > 0.0 && spacing.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        #[test]
        fn every_face_has_a_ball_that_holds_no_point(
            rows in prop::collection::vec(prop::array::uniform6(-1.0f32..1.0), 3..60),
        ) {
            let points: Vec<[f32; 3]> = rows.iter().map(|row| [row[0], row[1], 0.3 * row[2]]).collect();
            let normals: Vec<[f32; 3]> = rows.iter().map(|row| [0.5 * row[3], 0.5 * row[4], 1.0]).collect();
            let faces = ball_pivoting(&points, &normals);
            let [points, normals] = [&points, &normals].map(|rows| to_double(rows));
            let spacing = average_spacing(&points).unwrap();
            let all: Vec<u32> = (0..points.len() as u32).collect();
            for &face in &faces {
                let fits = |multiple: &f64| {
                    let ball = Ball::new(&points, &normals, multiple * spacing);
                    ball.center(face).is_some_and(|center| ball.is_empty(center, face, &all))
                };
                prop_assert!(RADII.iter().any(fits), "{face:?}");
            }
            let mut edges: Vec<[u32; 2]> = faces.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
            edges.sort_unstable();
            prop_assert!(edges.windows(2).all(|pair| pair[0] != pair[1]));
        }
    }
}
