//! Ball pivoting: points with normals become triangles where a ball rests on three of them (Bernardini et al. 1999).
//!
//! A ball starts on three points with none inside, and rolls over each open edge of the faces so far until it rests on
//! a next point. Larger balls go on where smaller ones fell through. What no ball bridges stays a hole.
//!
//! Ours, since the only crate for it, `bpa_rs`, knows one radius and one piece alone, gives triangles without indices,
//! and prints.

mod ball;
mod rolling;
mod seed;
mod sheet;

use glam::DVec3;

use ball::Ball;
use neural_mesh::spatial::nearest_neighbours;
use rolling::{extended, reopened, roll};
use seed::seed;
use sheet::Sheet;

/// Radii of the balls over the average distance of a point to its nearest one, as is usual in Open3D and MeshLab.
const RADII: [f64; 4] = [1.0, 1.5, 2.0, 4.0];

/// Meshes points by balls of several sizes.
///
/// Faces are wound so that they look along the normals of their corners. No edge has more than two faces. Takes time
/// quadratic in the number of points that a ball of the average spacing covers.
///
/// # Shapes
/// - `points`, `normals`: n x 3, finite; normals of any length
/// - returns n_faces x 3
///
/// # Panics
/// When there is not one normal per point.
///
/// ```
/// use neural_mesh_bench::baselines::ball_pivoting;
/// let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.5, 1.0, 0.0]];
/// assert_eq!(ball_pivoting(&points, &[[0.0, 0.0, 1.0]; 3]), [[0, 1, 2]]);
/// ```
pub fn ball_pivoting(points: &[[f32; 3]], normals: &[[f32; 3]]) -> Vec<[u32; 3]> {
    assert_eq!(points.len(), normals.len(), "one normal per point");
    let [points, normals] = [points, normals].map(in_double);
    let mut sheet = Sheet::new(points.len());
    let Some(spacing) = average_spacing(&points) else { return Vec::new() };
    for radius in RADII.map(|multiple| multiple * spacing) {
        let ball = Ball::new(&points, &normals, radius);
        let front = reopened(&ball, &sheet);
        roll(&ball, &mut sheet, front);
        for v in 0..points.len() as u32 {
            if let Some(seed) = seed(&ball, &sheet, v) {
                let front = extended(&mut sheet, seed);
                roll(&ball, &mut sheet, front);
            }
        }
    }
    sheet.into_faces()
}

fn in_double(rows: &[[f32; 3]]) -> Vec<DVec3> {
    rows.iter().map(|row| DVec3::from_array(row.map(f64::from))).collect()
}

/// The mean distance of a point to its nearest one; none where all points are one.
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
            let [points, normals] = [&points, &normals].map(|rows| in_double(rows));
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
