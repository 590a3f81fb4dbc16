//! The curvature-preservation loss.

use super::PointLoss;
use glam::{DMat3, DVec3};
use neural_mesh::geometry::eigenvalues;
use neural_mesh::parallel;
use neural_mesh::spatial::nearest_neighbours;

// Neighbours of a curvature estimate, as in the measure of the paper's Table 2.
const NEIGHBOURS: usize = 10;

/// Returns the curvature of each point (surface variation, Pauly et al. 2002), averaged over it and its 10
/// neighbours.
///
/// # Shapes
/// - `points`: n x 3, finite
/// - returns n numbers in 0..=1/3
pub fn mean_curvature(points: &[[f32; 3]]) -> Vec<f64> {
    PointStars::new(points).means()
}

/// Computes `1/n sum_s (K(s) - k_s)^2` with mean curvatures K of samples and wanted ones k, and its gradient.
///
/// # Shapes
/// - `samples`: n x 3; `wanted`: n
pub fn curvature_preservation(samples: &[[f32; 3]], wanted: &[f64]) -> PointLoss {
    let n = samples.len() as f64;
    let stars = PointStars::new(samples);
    let differences: Vec<f64> = stars.means().iter().zip(wanted).map(|(found, wanted)| found - wanted).collect();
    let value = differences.iter().map(|d| d * d).sum::<f64>() / n;
    // The choice of neighbours is treated as constant.
    let mut to_kappa = vec![0.0; samples.len()];
    for (s, difference) in differences.iter().enumerate() {
        let members = stars.members(s);
        let share = 2.0 * difference / (n * members.len() as f64);
        members.iter().for_each(|&m| to_kappa[m] += share);
    }
    let mut gradient = vec![[0.0; 3]; samples.len()];
    for (s, &to_kappa) in to_kappa.iter().enumerate() {
        for (member, slope) in stars.slopes(s) {
            gradient[member].iter_mut().zip(slope.to_array()).for_each(|(g, slope)| *g += to_kappa * slope);
        }
    }
    PointLoss { value, gradient }
}

struct PointStars<'a> {
    points: &'a [[f32; 3]],
    neighbours: Vec<u32>,
    width: usize,
}

impl<'a> PointStars<'a> {
    fn new(points: &'a [[f32; 3]]) -> Self {
        let neighbours = nearest_neighbours(points, NEIGHBOURS);
        Self { points, width: neighbours.len() / points.len().max(1), neighbours }
    }

    fn members(&self, s: usize) -> Vec<usize> {
        let nearest = &self.neighbours[s * self.width..][..self.width];
        [s].into_iter().chain(nearest.iter().map(|&m| m as usize)).collect()
    }

    fn spread(&self, s: usize) -> Vec<DVec3> {
        let places: Vec<DVec3> =
            self.members(s).into_iter().map(|m| DVec3::from_array(self.points[m].map(f64::from))).collect();
        let mean = places.iter().sum::<DVec3>() / places.len() as f64;
        places.into_iter().map(|place| place - mean).collect()
    }

    fn means(&self) -> Vec<f64> {
        let kappa = parallel::map(self.points.len(), 64, |s| kappa(&covariance(&self.spread(s))));
        let mean = |s: usize| {
            let members = self.members(s);
            members.iter().map(|&m| kappa[m]).sum::<f64>() / members.len() as f64
        };
        (0..self.points.len()).map(mean).collect()
    }

    fn slopes(&self, s: usize) -> Vec<(usize, DVec3)> {
        let spread = self.spread(s);
        let covariance = covariance(&spread);
        let trace = trace(&covariance);
        // The slope by a member at offset d is `2 ((v . d) v - kappa d) / trace`, with the unit eigenvector v of the
        // least eigenvalue.
        let (kappa, v) = (kappa(&covariance), flattest(&covariance));
        let slope = |d: DVec3| if trace > 0.0 { 2.0 * (v.dot(d) * v - kappa * d) / trace } else { DVec3::ZERO };
        self.members(s).into_iter().zip(spread).map(|(m, d)| (m, slope(d))).collect()
    }
}

fn covariance(spread: &[DVec3]) -> [f64; 6] {
    let mut sums = [0.0; 6];
    for d in spread {
        let products = [d.x * d.x, d.x * d.y, d.x * d.z, d.y * d.y, d.y * d.z, d.z * d.z];
        sums.iter_mut().zip(products).for_each(|(sum, product)| *sum += product);
    }
    sums
}

fn trace([xx, _, _, yy, _, zz]: &[f64; 6]) -> f64 {
    xx + yy + zz
}

fn kappa(covariance: &[f64; 6]) -> f64 {
    let trace = trace(covariance);
    if trace > 0.0 { (eigenvalues(*covariance)[0] / trace).clamp(0.0, 1.0 / 3.0) } else { 0.0 }
}

fn flattest(covariance: &[f64; 6]) -> DVec3 {
    let [xx, xy, xz, yy, yz, zz] = *covariance;
    let least = eigenvalues(*covariance)[0];
    let rest = DMat3::from_cols(
        DVec3::new(xx - least, xy, xz),
        DVec3::new(xy, yy - least, yz),
        DVec3::new(xz, yz, zz - least),
    );
    // All cross products vanish where the eigenvector is not unique; the result is then zero.
    let crossed = [rest.x_axis.cross(rest.y_axis), rest.y_axis.cross(rest.z_axis), rest.z_axis.cross(rest.x_axis)];
    let longest = crossed.into_iter().max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
    longest.unwrap_or_default().normalize_or_zero()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::test_values::{assert_slopes, random};

    fn sheet(n: usize) -> Vec<[f32; 3]> {
        let rows = random(n, 3, 5);
        (0..n).map(|i| rows.row(i)).map(|r| [r[0], r[1], 0.5 * r[0] * r[0] + 0.1 * r[2]]).collect()
    }

    #[test]
    fn the_mean_is_that_of_the_measure_without_its_gaussian() {
        let points = sheet(60);
        let raw: Vec<f64> = (0..60).map(|s| kappa(&covariance(&PointStars::new(&points).spread(s)))).collect();
        let found = mean_curvature(&points);
        let nearest = nearest_neighbours(&points, 10);
        let naive = |s: usize| (raw[s] + nearest[10 * s..][..10].iter().map(|&m| raw[m as usize]).sum::<f64>()) / 11.0;
        assert!((0..60).all(|s| (found[s] - naive(s)).abs() < 1e-12));
        let measured = neural_mesh::spatial::point_curvature(&points);
        assert!(found.iter().zip(&measured).all(|(a, &b)| (a - f64::from(b)).abs() < 0.03));
    }

    #[test]
    fn the_gradient_has_the_slopes_of_the_loss() {
        let samples = sheet(25);
        let wanted: Vec<f64> = (0..25).map(|i| f64::from(i) / 200.0).collect();
        let neighbours = nearest_neighbours(&samples, NEIGHBOURS);
        // The loss has constant neighbours and double precision.
        let loss = |x: &[f64]| {
            let place = |m: usize| DVec3::from_slice(&x[3 * m..]);
            let of_star = |s: usize| {
                let members: Vec<usize> =
                    [s].into_iter().chain(neighbours[10 * s..][..10].iter().map(|&m| m as usize)).collect();
                let mean = members.iter().map(|&m| place(m)).sum::<DVec3>() / 11.0;
                let spread: Vec<DVec3> = members.iter().map(|&m| place(m) - mean).collect();
                (kappa(&covariance(&spread)), members)
            };
            let all: Vec<(f64, Vec<usize>)> = (0..25).map(of_star).collect();
            let mean = |s: usize| all[s].1.iter().map(|&m| all[m].0).sum::<f64>() / 11.0;
            (0..25).map(|s| (mean(s) - wanted[s]).powi(2)).sum::<f64>() / 25.0
        };
        let found = curvature_preservation(&samples, &wanted);
        let flat: Vec<f64> = samples.iter().flatten().map(|&x| f64::from(x)).collect();
        assert!((found.value - loss(&flat)).abs() < 1e-12);
        // The loss is scaled, so that differences exceed the rounding.
        let gradient: Vec<f32> = found.gradient.iter().flatten().map(|&g| (1e3 * g) as f32).collect();
        assert_slopes(&gradient, samples.as_flattened(), |x| 1e3 * loss(x));
    }

    #[test]
    fn equal_points_have_no_curvature_and_no_slope() {
        let plane: Vec<[f32; 3]> = (0..100).map(|i| [(i % 10) as f32, (i / 10) as f32, 0.0]).collect();
        assert!(mean_curvature(&plane).iter().all(|kappa| *kappa < 1e-9));
        let sphere = neural_mesh::mesh::shapes::icosphere(2);
        assert_eq!(curvature_preservation(sphere.positions(), &mean_curvature(sphere.positions())).value, 0.0);
        let loss = curvature_preservation(&[[1.0; 3]; 20], &[0.0; 20]);
        assert!(loss.value == 0.0 && loss.gradient.iter().flatten().all(|&g| g == 0.0));
    }
}
