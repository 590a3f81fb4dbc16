//! Distances along a surface by the heat method: Crane, Weischedel and Wardetzky, "Geodesics in Heat" (2013).
//!
//! On the intrinsic Delaunay triangles of the [`Laplacian`], so that bad triangles do no harm. The distances are smoothed
//! over about one edge length, and a few percent off where edges are long.

use super::factor::Factor;
use super::longest_way::longest_way;
use crate::along_surface::laplacian::{Glued, Laplacian};
use neural_mesh::geometry::sides::area;

/// What keeps the Laplacian alone from being singular, as a share of its usual first eigenvalue.
const SHIFT: f64 = 1e-7;

/// How often the heat may fall by a factor of e on the longest way: what is left of it, e^-500, is a number, and so is what is left
/// where the way is longer than was found by up to two fifths.
const MOST_FALLS: f64 = 500.0;

/// A surface made ready for distances from any of its vertices.
pub struct HeatMethod {
    /// One short step of heat flow.
    flow: Factor,
    /// The Laplacian alone.
    poisson: Factor,
}

impl HeatMethod {
    /// Factors both systems; `None` where rounding makes one indefinite.
    ///
    /// The time step is the square of the mean edge length, and on surfaces that are longer than 500 edges the square of a 500th of
    /// their length: with a shorter one no heat would arrive at the other end that a number can hold.
    ///
    /// ```
    /// use neural_mesh::mesh::shapes;
    /// use neural_mesh_bench::along_surface::{HeatMethod, Laplacian};
    /// let sphere = Laplacian::new(&shapes::icosphere(4)).unwrap();
    /// let distances = HeatMethod::new(&sphere).unwrap().distances(&sphere, 0);
    /// let farthest = distances.iter().fold(0.0, |a: f64, b| a.max(*b));
    /// assert!(distances[0] == 0.0 && (farthest - std::f64::consts::PI).abs() < 0.1);
    /// ```
    pub fn new(laplacian: &Laplacian) -> Option<Self> {
        let time = laplacian.surface.mean_length().max(longest_way(laplacian) / MOST_FALLS).powi(2);
        let shift = SHIFT * 4.0 * std::f64::consts::PI / laplacian.mass.iter().sum::<f64>();
        let factor = |a: f64, b: f64| Factor::new(&laplacian.mass, &laplacian.edges, a, b);
        Some(Self { flow: factor(time, 1.0)?, poisson: factor(1.0, shift)? })
    }

    /// Distances from the vertex at place `source` of [`Laplacian::vertices`] to all others, in the mesh's unit: n;
    /// infinite on other pieces. The Laplacian is the one that this was made of.
    ///
    /// # Panics
    /// Where `source` is not below n.
    pub fn distances(&self, laplacian: &Laplacian, source: u32) -> Vec<f64> {
        let mut spot = vec![0.0; laplacian.mass.len()];
        spot[source as usize] = 1.0;
        let heat = self.flow.solve(&spot);
        let distances = self.poisson.solve(&divergence(&laplacian.surface, &heat));
        let start = distances[source as usize];
        let here = laplacian.piece[source as usize];
        let reached =
            |(distance, &piece): (f64, &u32)| if piece == here { (distance - start).max(0.0) } else { f64::INFINITY };
        distances.into_iter().zip(&laplacian.piece).map(reached).collect()
    }
}

/// Divergence, integrated around each vertex, of the unit field that points away from the heat: n.
fn divergence(surface: &Glued, heat: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0; heat.len()];
    for face in 0..surface.start.len() / 3 {
        let corners = [0, 1, 2].map(|k| surface.start[3 * face + k] as usize);
        let flows = flows(surface.sides(3 * face), corners.map(|v| heat[v]));
        // Half of each copy of the face.
        (0..3).for_each(|k| sums[corners[k]] += 0.5 * flows[k]);
    }
    sums
}

/// What the unit field against the gradient of `values` gives to each corner of a triangle, laid flat.
fn flows(sides: [f64; 3], [u, v, w]: [f64; 3]) -> [f64; 3] {
    let [a, b, c] = sides;
    let (x, y) = ((a * a + c * c - b * b) / (2.0 * a), 2.0 * area(sides) / a);
    let along = (v - u) / a;
    let across = (w - u - along * x) / y;
    let length = along.hypot(across);
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

    /// Mean error of the distances from the first vertex, as a share of the largest.
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

    /// A tube 5000 edges long: after 700 there would be no heat that a number can hold.
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
    fn other_pieces_are_infinitely_far() {
        let laplacian = Laplacian::new(&shapes::many_boxes(3)).unwrap();
        let distances = HeatMethod::new(&laplacian).unwrap().distances(&laplacian, 0);
        let infinite = distances.iter().zip(&laplacian.piece).filter(|(distance, _)| distance.is_infinite());
        assert!(infinite.clone().count() * 3 == distances.len() * 2);
        assert!(infinite.into_iter().all(|(_, &piece)| piece != laplacian.piece[0]));
    }
}
