//! Draws points evenly over a surface.

use glam::DVec3;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

use super::TriMesh;
use crate::geometry::triangle::{area_normal_f64, corners_f64};

/// A point on a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceSample {
    /// Index of the face.
    pub face: u32,
    /// Barycentric weights, with sum 1.
    pub weights: [f64; 3],
}

impl SurfaceSample {
    /// Returns the position of the sample.
    pub fn point(&self, mesh: &TriMesh) -> DVec3 {
        let [a, b, c] = face_corners(mesh, self.face as usize);
        a * self.weights[0] + b * self.weights[1] + c * self.weights[2]
    }
}

/// Draws `n_samples` points by area, one from each of as many strips of equal area.
///
/// Strips follow the order of the faces.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::mesh::{TriMesh, surface_samples::surface_samples};
/// let mesh = TriMesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]).unwrap();
/// let samples = surface_samples(&mesh, 100, 0);
/// assert!(samples.len() == 100 && samples.iter().all(|s| s.point(&mesh).x + s.point(&mesh).y < 1.0 + 1e-9));
/// ```
pub fn surface_samples(mesh: &TriMesh, n_samples: usize, seed: u64) -> Vec<SurfaceSample> {
    let mut sum = 0.0;
    let add = |face: usize| {
        sum += area_normal_f64(face_corners(mesh, face)).length();
        sum
    };
    let mut area_up_to: Vec<f64> = (0..mesh.faces().len()).map(add).collect();
    if area_up_to.last() == Some(&0.0) {
        area_up_to = (1..=mesh.faces().len()).map(|i| i as f64).collect();
    }
    let Some(&total) = area_up_to.last() else { return Vec::new() };
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut face = 0;
    let draw = |i: usize| {
        let reach = (i as f64 + unit(&mut rng)) / n_samples as f64 * total;
        while face + 1 < area_up_to.len() && area_up_to[face] <= reach {
            face += 1;
        }
        SurfaceSample { face: face as u32, weights: uniform_weights(unit(&mut rng), unit(&mut rng)) }
    };
    (0..n_samples).map(draw).collect()
}

fn uniform_weights(x: f64, y: f64) -> [f64; 3] {
    let root = x.sqrt();
    let v = root * (1.0 - y);
    let w = root * y;
    [(1.0 - v - w).max(0.0), v, w]
}

fn unit(rng: &mut Xoshiro256PlusPlus) -> f64 {
    (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

fn face_corners(mesh: &TriMesh, face: usize) -> [DVec3; 3] {
    corners_f64(mesh.faces()[face].map(|v| mesh.positions()[v as usize]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn uneven() -> TriMesh {
        let positions = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [10.0, 0.0], [13.0, 0.0], [10.0, 3.0], [5.0, 0.0]];
        let positions = positions.map(|[x, y]| [x, y, 0.0]).to_vec();
        TriMesh::new(positions, vec![[0, 1, 2], [0, 1, 6], [3, 4, 5]]).unwrap()
    }

    #[test]
    fn faces_get_samples_by_area_and_all_of_them_evenly() {
        let mesh = uneven();
        let samples = surface_samples(&mesh, 1000, 3);
        let on = |face| samples.iter().filter(|s| s.face == face).count();
        assert_eq!([on(0), on(1), on(2)], [100, 0, 900]);
        let mean = samples.iter().filter(|s| s.face == 2).map(|s| s.point(&mesh)).sum::<DVec3>() / 900.0;
        assert!(mean.distance(DVec3::new(11.0, 1.0, 0.0)) < 0.1, "{mean}");
    }

    #[test]
    fn the_seed_decides() {
        let mesh = uneven();
        assert_eq!(surface_samples(&mesh, 50, 1), surface_samples(&mesh, 50, 1));
        assert_ne!(surface_samples(&mesh, 50, 1), surface_samples(&mesh, 50, 2));
    }

    #[test]
    fn surfaces_without_area_or_faces_are_no_trouble() {
        let points = TriMesh::new(vec![[1.0; 3]; 4], vec![[0, 1, 2], [1, 2, 3]]).unwrap();
        assert_eq!(surface_samples(&points, 10, 0).iter().filter(|s| s.face == 1).count(), 5);
        assert!(surface_samples(&TriMesh::default(), 10, 0).is_empty());
    }
}
