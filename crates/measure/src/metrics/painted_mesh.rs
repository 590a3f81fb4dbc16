//! Distances for colouring a mesh.

use super::surface::triangles;
use crate::geometry::triangle::area_normal_f64;
use crate::mesh::TriMesh;
use crate::parallel;
use crate::spatial::NearestOnTriangles;

const MOST_POINTS: usize = 120_000;

const MOST_STEPS: usize = 8;
/// Points that a thread takes at least.
const LEAST: usize = 64;

/// Distances at which a colour scale may end, weighted by area.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ColourScale {
    /// 95th percentile of the distances.
    pub p95: f32,
    /// 99th percentile of the distances.
    pub p99: f32,
    /// Largest distance.
    pub max: f32,
}

/// A mesh with the points to be coloured.
pub struct PaintedMesh<'a> {
    mesh: &'a TriMesh,
    /// Intervals between points along each side; 1 means the vertices only.
    pub steps: usize,
}

impl<'a> PaintedMesh<'a> {
    /// Chooses the points: the vertices if there are many faces, else up to 45 points per face.
    ///
    /// ```
    /// # use neural_mesh_measure as neural_mesh;
    /// use neural_mesh::{mesh::shapes, metrics::{PaintedMesh, closest_point_tree}};
    /// let (coarse, fine) = (shapes::icosphere(0), shapes::icosphere(3));
    /// let distances = PaintedMesh::new(&coarse).distances_to(&closest_point_tree(&fine));
    /// assert!(distances.len() == 20 * 45 && distances.iter().all(|&distance| distance < 0.21));
    /// ```
    pub fn new(mesh: &'a TriMesh) -> Self {
        Self { mesh, steps: choose_steps(mesh) }
    }

    /// Returns the distance of each point to another surface, in the mesh's unit.
    ///
    /// # Shapes
    /// n_vertices, or n_faces x points per face, row by row from the first corner (the order of `refine.js`).
    pub fn distances_to(&self, other: &NearestOnTriangles) -> Vec<f32> {
        let points = match self.steps {
            1 => self.mesh.positions().iter().map(|position| position.map(f64::from)).collect(),
            steps => face_points(self.mesh, steps),
        };
        let distance = |i: usize| other.nearest(points[i].into()).map_or(0.0, |hit| hit.distance2.sqrt() as f32);
        parallel::map(points.len(), LEAST, distance)
    }

    /// Returns each point's share of the mesh's area, in the order of [`Self::distances_to`].
    pub fn shares(&self) -> Vec<f64> {
        match self.steps {
            1 => vertex_shares(self.mesh),
            steps => point_shares(self.mesh, steps),
        }
    }
}

/// Builds the tree that finds closest points on a mesh.
pub fn closest_point_tree(mesh: &TriMesh) -> NearestOnTriangles {
    NearestOnTriangles::new(&triangles(mesh))
}

fn choose_steps(mesh: &TriMesh) -> usize {
    let fit = |steps: &usize| mesh.faces().len() * points_per_face(*steps) <= MOST_POINTS;
    (2..=MOST_STEPS).rev().find(fit).unwrap_or(1)
}

fn points_per_face(steps: usize) -> usize {
    (steps + 1) * (steps + 2) / 2
}

fn face_points(mesh: &TriMesh, steps: usize) -> Vec<[f64; 3]> {
    let mut points = Vec::with_capacity(mesh.faces().len() * points_per_face(steps));
    for face in mesh.faces() {
        let [a, b, c] = face.map(|v| mesh.positions()[v as usize].map(f64::from));
        for i in 0..=steps {
            for j in 0..=steps - i {
                let weights = [steps - i - j, i, j].map(|n| n as f64 / steps as f64);
                points.push(std::array::from_fn(|x| weights[0] * a[x] + weights[1] * b[x] + weights[2] * c[x]));
            }
        }
    }
    points
}

fn vertex_shares(mesh: &TriMesh) -> Vec<f64> {
    let mut shares = vec![0.0; mesh.positions().len()];
    for (face, share) in mesh.faces().iter().zip(face_shares(mesh)) {
        face.iter().for_each(|&v| shares[v as usize] += share / 3.0);
    }
    shares
}

fn point_shares(mesh: &TriMesh, steps: usize) -> Vec<f64> {
    let n = points_per_face(steps);
    face_shares(mesh).iter().flat_map(|share| std::iter::repeat_n(share / n as f64, n)).collect()
}

fn face_shares(mesh: &TriMesh) -> Vec<f64> {
    let corner = |v: u32| mesh.positions()[v as usize].map(f64::from).into();
    let areas: Vec<f64> = mesh.faces().iter().map(|face| area_normal_f64(face.map(corner)).length()).collect();
    let total: f64 = areas.iter().sum();
    let even = 1.0 / areas.len().max(1) as f64;
    areas.iter().map(|area| if total > 0.0 { area / total } else { even }).collect()
}

/// Returns the colour scale for pairs of a distance and its share of the area.
///
/// ```
/// # use neural_mesh_measure as neural_mesh;
/// use neural_mesh::metrics::colour_scale;
/// let scale = colour_scale((1..=100).map(|i| (i as f32, 1.0)).collect());
/// assert_eq!((scale.p95, scale.p99, scale.max), (95.0, 99.0, 100.0));
/// ```
pub fn colour_scale(mut weighed: Vec<(f32, f64)>) -> ColourScale {
    weighed.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let total: f64 = weighed.iter().map(|(_, share)| share).sum();
    let below = |part: f64| {
        let mut sum = 0.0;
        let reached = weighed.iter().find(|(_, share)| {
            sum += share;
            sum >= part * total
        });
        reached.map_or(0.0, |&(distance, _)| distance)
    };
    let max = weighed.last().map_or(0.0, |&(distance, _)| distance);
    ColourScale { p95: below(0.95), p99: below(0.99), max }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn vertices_of_a_sphere_are_off_another_by_the_difference_of_radii() {
        let sphere = shapes::icosphere(3);
        let double = sphere.positions().iter().map(|p| p.map(|x| 2.0 * x)).collect();
        let double = TriMesh::new(double, sphere.faces().to_vec()).unwrap();
        let found = PaintedMesh { mesh: &double, steps: 1 }.distances_to(&closest_point_tree(&sphere));
        assert_eq!(found.len(), double.positions().len());
        assert!(found.iter().all(|d| (d - 1.0).abs() < 0.01), "{found:?}");
    }

    #[test]
    fn the_scale_counts_area_not_vertices() {
        let even = |i: u32| (i as f32, 1.0);
        assert_eq!(colour_scale((1..=1000).map(even).collect()), ColourScale { p95: 950.0, p99: 990.0, max: 1000.0 });
        let heavy = vec![(3.0, 1.0), (1.0, 96.0), (2.0, 3.0)];
        assert_eq!(colour_scale(heavy), ColourScale { p95: 1.0, p99: 2.0, max: 3.0 });
        assert_eq!(colour_scale(Vec::new()), ColourScale::default());
    }

    #[test]
    fn vertices_and_points_share_the_area_of_their_faces() {
        let corners = vec![[0.0; 3], [3.0, 0.0, 0.0], [0.0, 1.0, 0.0], [3.0, 3.0, 0.0]];
        let mesh = TriMesh::new(corners, vec![[0, 1, 2], [1, 3, 2]]).unwrap();
        let are_close = |found: Vec<f64>, wanted: &[f64]| {
            assert!(found.len() == wanted.len() && found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-12));
        };
        are_close(vertex_shares(&mesh), &[3.0, 12.0, 12.0, 9.0].map(|doubled| doubled / 36.0));
        are_close(point_shares(&mesh, 1), &[3.0, 3.0, 3.0, 9.0, 9.0, 9.0].map(|doubled| doubled / 36.0));
        let point = TriMesh::new(vec![[1.0; 3]; 3], vec![[0, 1, 2]]).unwrap();
        are_close(vertex_shares(&point), &[1.0 / 3.0; 3]);
    }

    #[test]
    fn points_of_faces_see_what_the_corners_do_not() {
        let fine = shapes::icosphere(4);
        let coarse = shapes::icosphere(0);
        assert_eq!(choose_steps(&coarse), MOST_STEPS);
        assert_eq!(choose_steps(&shapes::icosphere(6)), 1);
        let points = face_points(&coarse, 8);
        assert_eq!(points.len(), 20 * 45);
        let [corners, inside] =
            [1, 8].map(|steps| PaintedMesh { mesh: &coarse, steps }.distances_to(&closest_point_tree(&fine)));
        let largest = |distances: Vec<f32>| distances.into_iter().fold(0.0, f32::max);
        // The centre of an icosahedron's face is 1 - 0.795 below the sphere.
        let (corners, inside) = (largest(corners), largest(inside));
        assert!(corners < 1e-3 && inside > 0.18 && inside < 0.206, "{corners} {inside}");
    }

    #[test]
    fn points_of_a_face_run_row_by_row_from_the_first_corner() {
        let mesh = TriMesh::new(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]]).unwrap();
        let flat = face_points(&mesh, 2).into_iter().map(|[x, y, _]| [x, y]);
        let wanted = [[0.0, 0.0], [0.0, 1.0], [0.0, 2.0], [1.0, 0.0], [1.0, 1.0], [2.0, 0.0]];
        assert_eq!(flat.collect::<Vec<_>>(), wanted);
    }
}
