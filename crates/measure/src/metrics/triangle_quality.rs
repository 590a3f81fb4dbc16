//! Shape quality of triangles.

use super::surface::triangles;
use crate::geometry::side_lengths::area;
use crate::geometry::triangle::corners_f64;
use crate::mesh::TriMesh;

/// Smallest angle, in degrees, below which a face is a sliver.
const SLIVER: f64 = 1.0;

/// Shape figures of all faces of a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct TriangleQuality {
    /// Smallest of all angles, in degrees.
    pub smallest_angle: f64,
    /// Mean of the faces' smallest angles, in degrees.
    pub mean_smallest_angle: f64,
    /// Median aspect ratio: longest edge over its height, scaled to 1 for equilateral faces.
    pub median_aspect: f64,
    /// Faces with an angle below one degree.
    pub slivers: usize,
}

/// Measures the triangles; `None` without faces.
///
/// ```
/// # use neural_mesh_measure as neural_mesh;
/// use neural_mesh::{mesh::shapes, metrics::triangle_quality};
/// let quality = triangle_quality(&shapes::icosphere(0)).unwrap();
/// assert!((quality.smallest_angle - 60.0).abs() < 1e-4 && (quality.median_aspect - 1.0).abs() < 1e-5);
/// assert_eq!(quality.slivers, 0);
/// ```
pub fn triangle_quality(mesh: &TriMesh) -> Option<TriangleQuality> {
    let sides: Vec<[f64; 3]> = triangles(mesh).into_iter().map(sides).collect();
    let angles: Vec<f64> = sides.iter().map(|&sides| smallest_angle(sides)).collect();
    let mut aspects: Vec<f64> = sides.iter().map(|&sides| aspect(sides)).collect();
    aspects.sort_unstable_by(f64::total_cmp);
    Some(TriangleQuality {
        smallest_angle: angles.iter().copied().reduce(f64::min)?,
        mean_smallest_angle: angles.iter().sum::<f64>() / angles.len() as f64,
        median_aspect: aspects[aspects.len() / 2],
        slivers: angles.iter().filter(|&&angle| angle < SLIVER).count(),
    })
}

fn sides(corners: [[f32; 3]; 3]) -> [f64; 3] {
    let [a, b, c] = corners_f64(corners);
    let mut sides = [a.distance(b), b.distance(c), c.distance(a)];
    sides.sort_unstable_by(f64::total_cmp);
    sides
}

fn smallest_angle([a, b, c]: [f64; 3]) -> f64 {
    (4.0 * area([a, b, c])).atan2(b * b + c * c - a * a).to_degrees()
}

fn aspect([a, b, c]: [f64; 3]) -> f64 {
    let doubled = 2.0 * area([a, b, c]);
    if doubled > 0.0 { c * c / doubled * 0.75f64.sqrt() } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_a_square_and_a_sliver() {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.5, -0.001, 0.0], [2.0, 0.0, 0.0]];
        let mesh = TriMesh::new(positions, vec![[0, 1, 2], [1, 0, 3], [0, 1, 4]]).unwrap();
        let quality = triangle_quality(&mesh).unwrap();
        assert_eq!((quality.slivers, quality.smallest_angle), (2, 0.0));
        let angles = 45.0 + 0.002f64.atan().to_degrees();
        assert!((quality.mean_smallest_angle - angles / 3.0).abs() < 1e-4, "{quality:?}");
        assert!((aspect([1.0, 1.0, 2f64.sqrt()]) - 3f64.sqrt()).abs() < 1e-12);
    }
}
