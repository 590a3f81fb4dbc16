//! A normalised point cloud.

use neural_mesh::linalg::Csr;
use neural_mesh::spatial::nearest_neighbours;
use std::sync::Arc;

/// Neighbours per point, as in the paper's refinement.
pub const NEIGHBOURS: usize = 15;

/// Centred points in units of their mean neighbour distance.
#[derive(Clone, Debug, PartialEq)]
pub struct Cloud {
    /// Normalised points, n x 3.
    pub points: Vec<[f32; 3]>,
    /// Nearest neighbours, n x n.
    pub graph: Arc<Csr>,
    /// Mean distance to the neighbours, n.
    pub radii: Vec<f32>,
    origin: [f64; 3],
    unit: f64,
}

impl Cloud {
    /// Normalises points; `None` where all coincide.
    ///
    /// # Shapes
    /// - `points`: n x 3, finite
    pub fn new(points: &[[f32; 3]]) -> Option<Self> {
        let n = points.len();
        let neighbours = nearest_neighbours(points, NEIGHBOURS);
        let k = neighbours.len() / n.max(1);
        let distance = |i: usize, j: u32| {
            let [p, q] = [points[i], points[j as usize]];
            (0..3).map(|axis| (f64::from(p[axis]) - f64::from(q[axis])).powi(2)).sum::<f64>().sqrt()
        };
        let radius = |i: usize| neighbours[i * k..][..k].iter().map(|&j| distance(i, j)).sum::<f64>() / k as f64;
        let radii: Vec<f64> = (0..n).map(radius).collect();
        let unit = radii.iter().sum::<f64>() / n as f64;
        if unit.is_nan() || unit <= 0.0 {
            return None;
        }
        let mean = |axis: usize| points.iter().map(|p| f64::from(p[axis])).sum::<f64>() / n as f64;
        let origin: [f64; 3] = std::array::from_fn(mean);
        let apply = |p: &[f32; 3]| std::array::from_fn(|axis| ((f64::from(p[axis]) - origin[axis]) / unit) as f32);
        Some(Self {
            points: points.iter().map(apply).collect(),
            graph: Csr::from_equal_rows(n, n, k, neighbours).into(),
            radii: radii.iter().map(|radius| (radius / unit) as f32).collect(),
            origin,
            unit,
        })
    }

    /// Converts normalised points to the input's coordinates.
    pub fn to_input(&self, points: &[[f32; 3]]) -> Vec<[f32; 3]> {
        let place =
            |p: &[f32; 3]| std::array::from_fn(|axis| (self.origin[axis] + self.unit * f64::from(p[axis])) as f32);
        points.iter().map(place).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_points_make_no_cloud() {
        assert_eq!(Cloud::new(&[]), None);
        assert_eq!(Cloud::new(&[[1.0; 3]; 20]), None);
    }

    #[test]
    fn points_are_centred_and_scaled() {
        let cloud = Cloud::new(&[[5.0, 0.0, 0.0], [9.0, 0.0, 0.0]]).unwrap();
        assert_eq!(cloud.points, [[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]]);
        assert_eq!(cloud.to_input(&cloud.points), [[5.0, 0.0, 0.0], [9.0, 0.0, 0.0]]);
    }

    #[test]
    fn the_frame_is_that_of_the_points() {
        let sphere = neural_mesh::mesh::shapes::icosphere(3);
        let cloud = Cloud::new(sphere.positions()).unwrap();
        let mean = cloud.radii.iter().sum::<f32>() / cloud.radii.len() as f32;
        assert!((mean - 1.0).abs() < 1e-5);
        let back = cloud.to_input(&cloud.points);
        let pairs = back.iter().flatten().zip(sphere.positions().iter().flatten());
        assert!(pairs.clone().all(|(a, b)| (a - b).abs() < 1e-6));
    }
}
