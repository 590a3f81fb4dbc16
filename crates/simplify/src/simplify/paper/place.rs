//! Placement of vertices at the minimum of their region's quadric (Garland and Heckbert 1997), an addition to the
//! paper.

use super::NO_SAMPLE;
use crate::geometry::Quadric;
use crate::geometry::triangle::area_normal_f64;
use crate::mesh::TriMesh;
use crate::mesh::half_edges::for_each_edge;
use crate::mesh::pulse::Pulse;
use crate::mesh::thread_ranges::indices_where;
use crate::parallel;
use glam::{DVec3, Vec3};

/// Pull of a vertex to its old position, over its quadric's trace.
const PULL: f64 = 1e-3;

/// Fewest samples of a thread at once.
const ROWS: usize = 256;

/// Weight of a boundary's lines relative to the planes of faces.
const BOUNDARY: f64 = 10.0;

/// Error added to that of each region, over the mean of all.
const LEAST_ERROR: f64 = 0.1;

/// Rounds in which vertices of turned faces return to their samples.
const ROUNDS: usize = 4;

/// Quadric of each region, about its sample.
pub(in crate::simplify) struct RegionQuadrics<'a> {
    positions: &'a [[f32; 3]],
    samples: &'a [u32],
    quadrics: Vec<Quadric>,
}

impl<'a> RegionQuadrics<'a> {
    /// Sums the quadrics of all regions; a face counts a third for the region of each corner.
    pub(in crate::simplify) fn new(mesh: &'a TriMesh, samples: &'a [u32], assignment: &[u32]) -> Self {
        let positions = mesh.positions();
        let mut quadrics = vec![Quadric::default(); samples.len()];
        let mut add = |v: u32, of: &dyn Fn(DVec3) -> Quadric| {
            let region = assignment[v as usize];
            if region != NO_SAMPLE {
                quadrics[region as usize] += of(point(positions, samples[region as usize]));
            }
        };
        for face in mesh.faces() {
            let corners = face.map(|v| point(positions, v));
            let normal = area_normal_f64(corners);
            // The length of the normal is twice the area.
            let weight = normal.length() / 6.0;
            let normal = normal.normalize_or_zero();
            face.iter().for_each(|&v| add(v, &|origin| Quadric::from_plane(normal, corners[0] - origin, weight)));
        }
        for_each_edge(positions.len(), mesh.faces(), |ends, sides| {
            if let [_] = sides {
                let [a, b] = ends.map(|v| point(positions, v));
                ends.iter().for_each(|&v| add(v, &|origin| line_quadric(a - origin, b - origin)));
            }
        });
        Self { positions, samples, quadrics }
    }

    /// Adds a third of the logarithm of each region's remaining error to the scores of its vertices.
    ///
    /// # Shapes
    /// - `assignment`, `scores` and the result: n_vertices
    pub(in crate::simplify) fn scores(&self, assignment: &[u32], scores: &[f32]) -> Vec<f32> {
        // At curvature c a region of width h leaves an error of about c^2 h^6. So a density changed by the cube root of
        // the error makes errors equal.
        let error = |quadric: &Quadric| quadric.value(minimum(quadric));
        let errors: Vec<f64> = parallel::map(self.quadrics.len(), ROWS, |i| error(&self.quadrics[i]));
        let mean = errors.iter().sum::<f64>() / errors.len().max(1) as f64;
        if mean <= 0.0 {
            return scores.to_vec();
        }
        let gains: Vec<f32> = errors.iter().map(|error| ((error / mean + LEAST_ERROR).ln() / 3.0) as f32).collect();
        let of_vertex = |(&region, &score): (&u32, &f32)| match region {
            NO_SAMPLE => score,
            region => score + gains[region as usize],
        };
        assignment.iter().zip(scores).map(of_vertex).collect()
    }

    /// Moves every sample to the minimum of its quadric, unless faces around it would turn over.
    ///
    /// # Shapes
    /// - `faces`: n_faces x 3 vertices of the mesh that are samples
    /// - returns the positions of the samples, n_samples x 3
    pub(in crate::simplify) fn place_samples(&self, faces: &[[u32; 3]]) -> Vec<[f32; 3]> {
        let move_of =
            |i: usize| (point(self.positions, self.samples[i]) + minimum(&self.quadrics[i])).as_vec3().to_array();
        let mut positions = self.positions.to_vec();
        let moved: Vec<[f32; 3]> = parallel::map(self.quadrics.len(), ROWS, move_of);
        self.samples.iter().zip(moved).for_each(|(&v, p)| positions[v as usize] = p);
        for _ in 0..ROUNDS {
            let normal = |positions: &[[f32; 3]], face: &[u32; 3]| area_normal_f64(face.map(|v| point(positions, v)));
            let has_turned = |_, face: &[u32; 3]| normal(&positions, face).dot(normal(self.positions, face)) <= 0.0;
            let turned = indices_where(Pulse::NONE, faces, has_turned);
            let corners = turned.iter().flat_map(|&face| faces[face as usize]);
            corners.for_each(|v| positions[v as usize] = self.positions[v as usize]);
        }
        self.samples.iter().map(|&v| positions[v as usize]).collect()
    }
}

/// Returns the minimum of a quadric, pulled to the origin; the origin if there is none.
fn minimum(quadric: &Quadric) -> DVec3 {
    let pulled = quadric.with_point(DVec3::ZERO, PULL * quadric.trace());
    pulled.minimum().map_or(DVec3::ZERO, |(x, _)| x)
}

/// Returns the squared distance to the line through two points, times [`BOUNDARY`] and the squared distance between the
/// points.
fn line_quadric(a: DVec3, b: DVec3) -> Quadric {
    let direction = (b - a).normalize_or_zero();
    let weight = BOUNDARY * a.distance_squared(b);
    // The squared distance to a line is that to two planes through it, at right angles.
    let (one, other) = direction.any_orthonormal_pair();
    Quadric::from_plane(one, a, weight) + Quadric::from_plane(other, a, weight)
}

fn point(positions: &[[f32; 3]], v: u32) -> DVec3 {
    Vec3::from(positions[v as usize]).as_dvec3()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    fn grid_and_regions(mesh: &TriMesh, samples: &[u32]) -> Vec<u32> {
        let distance2 = |v: u32, s: u32| point(mesh.positions(), v).distance_squared(point(mesh.positions(), s));
        let nearest =
            |v: u32| (0..samples.len()).min_by(|&a, &b| distance2(v, samples[a]).total_cmp(&distance2(v, samples[b])));
        (0..mesh.positions().len() as u32).map(|v| nearest(v).unwrap() as u32).collect()
    }

    #[test]
    fn a_region_at_a_corner_places_its_vertex_there() {
        // Three faces of a corner, whose apex belongs to the region of another vertex.
        let mesh = TriMesh::new(
            vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            vec![[0, 2, 1], [0, 1, 3], [0, 3, 2]],
        )
        .unwrap();
        let regions = RegionQuadrics::new(&mesh, &[1], &[0, 0, 0, 0]);
        let planes = RegionQuadrics { quadrics: vec![corner_quadrics()], ..regions };
        let placed = planes.place_samples(&[]);
        assert!(Vec3::from(placed[0]).as_dvec3().length() < 0.01, "{placed:?}");
    }

    fn corner_quadrics() -> Quadric {
        [DVec3::X, DVec3::Y, DVec3::Z]
            .into_iter()
            .fold(Quadric::default(), |sum, normal| sum + Quadric::from_plane(normal, DVec3::NEG_X, 1.0))
    }

    #[test]
    fn flat_regions_stay_and_turned_faces_go_back() {
        let flat = TriMesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]).unwrap();
        let regions = RegionQuadrics::new(&flat, &[0, 1, 2], &[0, 1, 2]);
        let is_near = |placed: &[[f32; 3]]| {
            placed.as_flattened().iter().zip(flat.positions().as_flattened()).all(|(a, b)| (a - b).abs() < 1e-6)
        };
        assert!(is_near(&regions.place_samples(flat.faces())));
        // A vertex that would cross the edge opposite to it stays.
        let far = Quadric::default().with_point([2.0, 2.0, 0.0].into(), 1.0);
        let regions = RegionQuadrics { quadrics: vec![far, Quadric::default(), Quadric::default()], ..regions };
        assert!(is_near(&regions.place_samples(flat.faces())));
        assert!(regions.place_samples(&[])[0][0] > 1.9);
    }

    #[test]
    fn curved_regions_get_more_samples() {
        let mesh = shapes::wavy_sphere(4, 5.0);
        let samples: Vec<u32> = (0..mesh.positions().len() as u32).step_by(40).collect();
        let assignment = grid_and_regions(&mesh, &samples);
        let regions = RegionQuadrics::new(&mesh, &samples, &assignment);
        let scores = regions.scores(&assignment, &vec![0.0; assignment.len()]);
        let errors: Vec<f64> = regions.quadrics.iter().map(|quadric| quadric.value(minimum(quadric))).collect();
        let worst = (0..errors.len()).max_by(|&a, &b| errors[a].total_cmp(&errors[b])).unwrap();
        let largest = scores.iter().copied().fold(f32::MIN, f32::max);
        assert_eq!(scores[samples[worst] as usize], largest);
        assert!(scores.iter().any(|&score| score < largest - 0.5));
    }
}
