//! Geodesic distances by the heat method (Crane, Weischedel and Wardetzky 2013, "Geodesics in Heat").

use super::factor::Factor;
use super::longest_path::longest_path;
use crate::along_surface::laplacian::{GluedTriangles, Laplacian};
use neural_mesh::geometry::side_lengths::area;

// Shift that makes the Laplacian regular, as a fraction of the usual first eigenvalue.
const SHIFT: f64 = 1e-7;

// Heat falls by at most this many factors of e along the longest path; e^-500 is still a normal number.
const MOST_FALLS: f64 = 500.0;

/// A surface prepared for geodesic distances, which are smoothed over about an edge length.
pub struct HeatMethod {
    flow: Factor,
    poisson: Factor,
}

impl HeatMethod {
    /// Factorises the matrices of the heat and Poisson equations; `None` where rounding makes one indefinite.
    pub fn new(laplacian: &Laplacian) -> Option<Self> {
        // The usual time step is the squared edge length; on long surfaces heat would underflow with it.
        let time = laplacian.surface.mean_length().max(longest_path(laplacian) / MOST_FALLS).powi(2);
        let shift = SHIFT * 4.0 * std::f64::consts::PI / laplacian.mass.iter().sum::<f64>();
        let factor = |a: f64, b: f64| Factor::new(&laplacian.mass, &laplacian.edges, a, b);
        Some(Self { flow: factor(time, 1.0)?, poisson: factor(1.0, shift)? })
    }

    /// Returns the distances from vertex `source` in the mesh's unit, n; infinite on other components.
    ///
    /// The `laplacian` must be that of [`HeatMethod::new`].
    ///
    /// # Panics
    /// If `source` is not below n.
    pub fn distances(&self, laplacian: &Laplacian, source: u32) -> Vec<f64> {
        let mut spot = vec![0.0; laplacian.mass.len()];
        spot[source as usize] = 1.0;
        let heat = self.flow.solve(&spot);
        // The gradient of the distances is the unit field away from the heat.
        let distances = self.poisson.solve(&divergence(&laplacian.surface, &heat));
        let start = distances[source as usize];
        let here = laplacian.component[source as usize];
        let reached = |(distance, &component): (f64, &u32)| {
            if component == here { (distance - start).max(0.0) } else { f64::INFINITY }
        };
        distances.into_iter().zip(&laplacian.component).map(reached).collect()
    }
}

fn divergence(surface: &GluedTriangles, heat: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0; heat.len()];
    for face in 0..surface.start.len() / 3 {
        let corners = [0, 1, 2].map(|k| surface.start[3 * face + k] as usize);
        let flows = flows(surface.sides(3 * face), corners.map(|v| heat[v]));
        // Each face has two copies, each of which counts half.
        (0..3).for_each(|k| sums[corners[k]] += 0.5 * flows[k]);
    }
    sums
}

fn flows(sides: [f64; 3], [u, v, w]: [f64; 3]) -> [f64; 3] {
    let [a, b, c] = sides;
    // The flattened triangle has the corners (0, 0), (a, 0) and (x, y).
    let (x, y) = ((a * a + c * c - b * b) / (2.0 * a), 2.0 * area(sides) / a);
    let along = (v - u) / a;
    let across = (w - u - along * x) / y;
    let length = along.hypot(across);
    // Without a gradient there is no direction.
    if length == 0.0 || !length.is_finite() {
        return [0.0; 3];
    }
    let (along, across) = (-along / length, -across / length);
    let second = 0.5 * (y * along - x * across);
    let third = 0.5 * a * across;
    [-second - third, second, third]
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use neural_mesh::mesh::{TriMesh, shapes};

    fn error(mesh: &TriMesh, exact: impl Fn(DVec3, DVec3) -> f64) -> f64 {
        let laplacian = Laplacian::new(mesh).unwrap();
        let distances = HeatMethod::new(&laplacian).unwrap().distances(&laplacian, 0);
        let points: Vec<DVec3> = mesh.positions().iter().map(|p| DVec3::from_array(p.map(f64::from))).collect();
        let wanted: Vec<f64> = points.iter().map(|&p| exact(points[0], p)).collect();
        let sum: f64 = distances.iter().zip(&wanted).map(|(a, b)| (a - b).abs()).sum();
        sum / wanted.len() as f64 / wanted.iter().fold(0.0, |a: f64, b| a.max(*b))
    }

    #[test]
    fn along_a_plane_it_is_the_straight_distance() {
        assert!(error(&shapes::grid(60, 60), |p, q| p.distance(q)) < 0.01);
    }

    #[test]
    fn along_a_sphere_it_is_the_angle() {
        assert!(error(&shapes::icosphere(5), |p, q| p.normalize().dot(q.normalize()).clamp(-1.0, 1.0).acos()) < 0.01);
    }

    // A tube of 5000 edges: without the longer time step heat would underflow after 700.
    #[test]
    fn heat_arrives_at_the_end_of_a_long_tube() {
        let (n_around, n_up) = (6, 5000);
        let corner = |i: u32, j: u32| {
            let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / f64::from(n_around)).sin_cos();
            [cos as f32, sin as f32, j as f32]
        };
        let positions = (0..=n_up).flat_map(|j| (0..n_around).map(move |i| corner(i, j))).collect();
        let at = |i: u32, j: u32| j * n_around + i % n_around;
        let quad =
            |i: u32, j: u32| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]];
        let faces = (0..n_up).flat_map(|j| (0..n_around).flat_map(move |i| quad(i, j))).collect();
        let error = error(&TriMesh::new(positions, faces).unwrap(), |p, q| (q - p).z);
        assert!(error < 2e-3, "{error}");
    }

    #[test]
    fn other_components_are_infinitely_far() {
        let laplacian = Laplacian::new(&shapes::many_boxes(3)).unwrap();
        let distances = HeatMethod::new(&laplacian).unwrap().distances(&laplacian, 0);
        let infinite = distances.iter().zip(&laplacian.component).filter(|(distance, _)| distance.is_infinite());
        assert!(infinite.clone().count() * 3 == distances.len() * 2);
        assert!(infinite.into_iter().all(|(_, &component)| component != laplacian.component[0]));
    }
}
