//! Two-sided distance in position and normal.

use glam::DVec3;

use super::Surface;
use super::search_budget::affordable_count;
use crate::parallel;

const CHUNK: usize = 512;
/// Largest number of triangles and boxes visited: in total, or per point if that is more.
const MAX_VISITS: [f64; 2] = [4e6, 120.0];

/// Distances from the samples of one surface to another, in the mesh's unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct OneSidedDistance {
    /// Mean distance.
    pub mean: f64,
    /// Root mean square distance.
    pub rms: f64,
    /// Largest distance over samples and vertices.
    pub max: f64,
    /// Mean of `1 - n.n'`, 0 to 2, for normals at the sample and the closest face.
    pub normal_error: f64,
    /// Mean of `1 - |n.n'|`, 0 to 1: the paper's NE.
    pub unsigned_normal_error: f64,
    /// Mean angle between the unoriented normals, in radians.
    pub normal_angle: f64,
}

/// Distances in both directions and combined.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct SurfaceDistance {
    /// Original to simplified.
    pub forward: OneSidedDistance,
    /// Simplified to original.
    pub backward: OneSidedDistance,
    /// Combined: means, the root mean square for `rms`, the maximum for `max` (Hausdorff).
    pub both: OneSidedDistance,
    /// Diagonal of the original's bounding box.
    pub diagonal: f64,
}

/// Measures the two-sided distance; `None` if a surface has no faces or no samples.
///
/// Faces without area have no normal and count for the distance only. Heavily intersecting large faces reduce the
/// samples.
///
/// ```
/// # use neural_mesh_measure as neural_mesh;
/// use neural_mesh::{mesh::TriMesh, metrics::{Surface, surface_distance}};
/// let triangle_at_height = |z: f32| TriMesh::new(vec![[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]], vec![[0, 1, 2]]).unwrap();
/// let [low, high] = [0.0, 0.5].map(|z| Surface::new(&triangle_at_height(z), 100, 0));
/// let distance = surface_distance(&low, &high).unwrap();
/// assert_eq!((distance.both.mean, distance.both.max, distance.both.normal_error), (0.5, 0.5, 0.0));
/// ```
pub fn surface_distance(original: &Surface, simplified: &Surface) -> Option<SurfaceDistance> {
    let forward = measure_one_way(original, simplified)?;
    let backward = measure_one_way(simplified, original)?;
    let both = OneSidedDistance {
        mean: 0.5 * (forward.mean + backward.mean),
        rms: (0.5 * (forward.rms.powi(2) + backward.rms.powi(2))).sqrt(),
        max: forward.max.max(backward.max),
        normal_error: 0.5 * (forward.normal_error + backward.normal_error),
        unsigned_normal_error: 0.5 * (forward.unsigned_normal_error + backward.unsigned_normal_error),
        normal_angle: 0.5 * (forward.normal_angle + backward.normal_angle),
    };
    Some(SurfaceDistance { forward, backward, both, diagonal: original.diagonal })
}

#[derive(Clone, Copy, Default)]
struct Sums {
    distance: f64,
    distance2: f64,
    max: f64,
    normal_error: f64,
    unsigned_normal_error: f64,
    normal_angle: f64,
    with_normal: usize,
}

fn measure_one_way(from: &Surface, to: &Surface) -> Option<OneSidedDistance> {
    if from.samples.is_empty() || to.normals.is_empty() {
        return None;
    }
    let samples = affordable_subset(&from.samples, to);
    let parts = parallel::chunks(&samples, CHUNK, |_, samples| sum_samples(from, to, samples));
    let all = parts.into_iter().fold(Sums::default(), |a, b| Sums {
        distance: a.distance + b.distance,
        distance2: a.distance2 + b.distance2,
        max: a.max.max(b.max),
        normal_error: a.normal_error + b.normal_error,
        unsigned_normal_error: a.unsigned_normal_error + b.unsigned_normal_error,
        normal_angle: a.normal_angle + b.normal_angle,
        with_normal: a.with_normal + b.with_normal,
    });
    let n = samples.len() as f64;
    let n_normals = all.with_normal.max(1) as f64;
    Some(OneSidedDistance {
        mean: all.distance / n,
        rms: (all.distance2 / n).sqrt(),
        max: all.max.max(farthest_vertex(from, to)),
        normal_error: all.normal_error / n_normals,
        unsigned_normal_error: all.unsigned_normal_error / n_normals,
        normal_angle: all.normal_angle / n_normals,
    })
}

fn farthest_vertex(from: &Surface, to: &Surface) -> f64 {
    let distance2 = |v: usize| to.nearest.nearest(from.vertices[v]).map_or(0.0, |hit| hit.distance2);
    let vertices = affordable_subset(&from.vertices, to);
    let largest = |_, vertices: &[usize]| vertices.iter().map(|&v| distance2(v)).fold(0.0, f64::max);
    parallel::chunks(&vertices, CHUNK, largest).into_iter().fold(0.0, f64::max).sqrt()
}

fn affordable_subset(points: &[DVec3], to: &Surface) -> Vec<usize> {
    let n = points.len();
    let most = MAX_VISITS[0].max(MAX_VISITS[1] * n as f64);
    let n_affordable = affordable_count(n, most, |i| to.nearest.nearest_with_cost(points[i]).1);
    (0..n_affordable).map(|i| i * n / n_affordable).collect()
}

fn sum_samples(from: &Surface, to: &Surface, samples: &[usize]) -> Sums {
    let mut sums = Sums::default();
    for &i in samples {
        let Some(hit) = to.nearest.nearest(from.samples[i]) else { continue };
        sums.distance += hit.distance2.sqrt();
        sums.distance2 += hit.distance2;
        sums.max = sums.max.max(hit.distance2.sqrt());
        let normal = from.normals[from.sample_faces[i] as usize];
        let other = to.normals[hit.triangle as usize];
        if normal.length_squared() > 0.0 && other.length_squared() > 0.0 {
            sums.normal_error += 1.0 - normal.dot(other);
            sums.unsigned_normal_error += 1.0 - normal.dot(other).abs();
            // The arc cosine would lose half of the digits of small angles.
            sums.normal_angle += normal.cross(other).length().atan2(normal.dot(other).abs());
            sums.with_normal += 1;
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{TriMesh, shapes};
    use crate::metrics::tests::faces_across;

    fn surface(mesh: &TriMesh) -> Surface {
        Surface::new(mesh, 4000, 0)
    }

    fn scale_mesh(mesh: &TriMesh, by: f32) -> TriMesh {
        let positions = mesh.positions().iter().map(|p| p.map(|x| by * x)).collect();
        TriMesh::new(positions, mesh.faces().to_vec()).unwrap()
    }

    #[test]
    fn spheres_in_each_other_are_as_far_apart_as_their_radii() {
        let sphere = shapes::icosphere(4);
        let distance = surface_distance(&surface(&sphere), &surface(&scale_mesh(&sphere, 1.1))).unwrap();
        for side in [distance.forward, distance.backward, distance.both] {
            assert!((side.mean - 0.1).abs() < 2e-3 && (side.rms - 0.1).abs() < 2e-3 && (side.max - 0.1).abs() < 4e-3);
            assert!((0.0..2e-3).contains(&side.normal_error));
        }
        assert!((distance.diagonal - 12f64.sqrt()).abs() < 0.02);
    }

    #[test]
    fn a_surface_is_at_no_distance_from_itself() {
        let bolt = shapes::bolt(32);
        let distance = surface_distance(&surface(&bolt), &Surface::new(&bolt, 4000, 5)).unwrap();
        assert!(distance.both.max < 1e-12 && distance.both.normal_error < 1e-9, "{distance:?}");
    }

    #[test]
    fn a_missing_part_counts_from_the_side_that_has_it() {
        let whole = shapes::many_boxes(2);
        let half = TriMesh::new(whole.positions().to_vec(), whole.faces()[..12].to_vec()).unwrap();
        let distance = surface_distance(&surface(&whole), &surface(&half)).unwrap();
        assert!(distance.forward.max > 0.1 && distance.backward.max < 1e-12);
        assert_eq!(distance.both.max, distance.forward.max);
    }

    #[test]
    fn a_surface_turned_over_has_the_largest_normal_error() {
        let cube = shapes::cuboid([1.0; 3], 2);
        let over = cube.faces().iter().map(|&[a, b, c]| [a, c, b]).collect();
        let over = TriMesh::new(cube.positions().to_vec(), over).unwrap();
        let distance = surface_distance(&surface(&cube), &surface(&over)).unwrap();
        assert!((distance.both.normal_error - 2.0).abs() < 1e-9);
        assert!(distance.both.unsigned_normal_error.abs() < 1e-9);
    }

    #[test]
    fn a_tilt_shows_in_both_normal_errors() {
        let square = |y: f32, z: f32| {
            let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, y, z], [0.0, y, z]];
            surface(&TriMesh::new(positions, vec![[0, 1, 2], [0, 2, 3]]).unwrap())
        };
        let distance = surface_distance(&square(1.0, 0.0), &square(0.5, 0.75f32.sqrt())).unwrap();
        assert!((distance.both.normal_error - 0.5).abs() < 1e-6, "{distance:?}");
        assert!((distance.both.unsigned_normal_error - 0.5).abs() < 1e-6, "{distance:?}");
        assert!((distance.both.normal_angle.to_degrees() - 60.0).abs() < 1e-4, "{distance:?}");
    }

    #[test]
    fn large_faces_across_each_other_get_fewer_samples() {
        let sphere = shapes::icosphere(4);
        let [across, moved] =
            faces_across(&sphere, 2500, [711, 1200, 1279, 500]).map(|mesh| Surface::new(&mesh, 200_000, 0));
        let n_samples = affordable_subset(&across.samples, &moved).len();
        assert!((64..150_000).contains(&n_samples), "{n_samples}");
        let distance = surface_distance(&across, &moved).unwrap();
        assert!(distance.both.mean > 0.0 && distance.both.max <= 0.0101, "{distance:?}");
        let sphere = Surface::new(&sphere, 5000, 0);
        assert_eq!(affordable_subset(&sphere.samples, &sphere), (0..5000).collect::<Vec<_>>());
    }
}
