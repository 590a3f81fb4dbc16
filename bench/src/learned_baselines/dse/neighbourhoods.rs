//! Neighbourhoods in local frames, the input of the networks.

use super::{CANDIDATES, KEPT};
use glam::{DMat3, DVec3, Vec3};
use neural_mesh::linalg::Matrix;
use neural_mesh::spatial::nearest_neighbours;

// Sweeps of Jacobi rotations; after five, symmetric 3 x 3 matrices are diagonal up to rounding.
const SWEEPS: usize = 6;

/// Candidates of all points of a cloud.
#[derive(Clone, Debug, PartialEq)]
pub struct Neighbourhoods<'a> {
    points: &'a [[f32; 3]],
    nearest: Vec<u32>,
    k: usize,
}

/// The local frame of a neighbourhood.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchFrame {
    origin: DVec3,
    // Directions of largest, middle and smallest spread.
    axes: [DVec3; 3],
    /// Diagonal of the candidates' box; above 0.
    pub unit: f64,
}

impl<'a> Neighbourhoods<'a> {
    /// Finds the [`CANDIDATES`] nearest points of each point, or all others.
    ///
    /// # Shapes
    /// - `points`: n x 3, finite
    pub fn new(points: &'a [[f32; 3]]) -> Self {
        let k = CANDIDATES.min(points.len().saturating_sub(1));
        Self { points, nearest: nearest_neighbours(points, CANDIDATES), k }
    }

    /// Returns the number of points per neighbourhood.
    pub fn group(&self) -> usize {
        self.k + 1
    }

    /// Returns the point `centre`, followed by its candidates.
    pub fn candidates(&self, centre: u32) -> Vec<u32> {
        let nearest = &self.nearest[centre as usize * self.k..][..self.k];
        std::iter::once(centre).chain(nearest.iter().copied()).collect()
    }

    /// Returns the frame of a point: position, principal axes and size of its neighbourhood.
    pub fn frame(&self, centre: u32) -> PatchFrame {
        let at = |v: u32| Vec3::from(self.points[v as usize]).as_dvec3();
        let candidates = self.candidates(centre);
        let offsets: Vec<DVec3> = candidates.iter().map(|&v| at(v) - at(centre)).collect();
        let near = &offsets[..offsets.len().min(KEPT + 1)];
        let mut axes = principal_axes(near);
        // The third moment decides each axis's sign; the paper's program turns patches at random instead.
        for axis in &mut axes {
            let lean: f64 = near.iter().map(|offset| axis.dot(*offset).powi(3)).sum();
            *axis = if lean < 0.0 { -*axis } else { *axis };
        }
        let turned = |offset: &DVec3| DVec3::from(axes.map(|axis| axis.dot(*offset)));
        let low = offsets.iter().map(turned).fold(DVec3::ZERO, DVec3::min);
        let high = offsets.iter().map(turned).fold(DVec3::ZERO, DVec3::max);
        let diagonal = (high - low).length();
        PatchFrame { origin: at(centre), axes, unit: if diagonal > 0.0 { diagonal } else { 1.0 } }
    }

    /// Returns the coordinates of points in a frame.
    pub fn coordinates<'b>(&'b self, points: &'b [u32], frame: PatchFrame) -> impl Iterator<Item = f32> + 'b {
        points.iter().flat_map(move |&v| {
            let offset = (Vec3::from(self.points[v as usize]).as_dvec3() - frame.origin) / frame.unit;
            frame.axes.map(|axis| axis.dot(offset) as f32)
        })
    }

    /// Returns the coordinates of neighbourhoods, (n * group) x 3.
    pub fn places(&self, patches: &[Vec<u32>], frames: &[PatchFrame]) -> Matrix {
        let entries: Vec<f32> =
            patches.iter().zip(frames).flat_map(|(patch, &frame)| self.coordinates(patch, frame)).collect();
        Matrix::new(entries.len() / 3, 3, entries)
    }
}

fn principal_axes(offsets: &[DVec3]) -> [DVec3; 3] {
    let mean = offsets.iter().sum::<DVec3>() / offsets.len().max(1) as f64;
    let outer = |d: DVec3| DMat3::from_cols(d * d.x, d * d.y, d * d.z);
    let mut moments = offsets.iter().fold(DMat3::ZERO, |sum, &offset| sum + outer(offset - mean));
    // Rotations diagonalise the covariance (Jacobi 1846).
    let mut axes = DMat3::IDENTITY;
    for _ in 0..SWEEPS {
        for [p, q] in [[0, 1], [0, 2], [1, 2]] {
            let rotation = jacobi_rotation(&moments, p, q);
            moments = rotation.transpose() * moments * rotation;
            axes *= rotation;
        }
    }
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| moments.col(b)[b].total_cmp(&moments.col(a)[a]));
    order.map(|column| axes.col(column))
}

fn jacobi_rotation(m: &DMat3, p: usize, q: usize) -> DMat3 {
    let beside = m.col(q)[p];
    let mut rotation = DMat3::IDENTITY;
    if beside == 0.0 {
        return rotation;
    }
    let ratio = (m.col(q)[q] - m.col(p)[p]) / (2.0 * beside);
    let tangent = 1.0f64.copysign(ratio) / (ratio.abs() + ratio.hypot(1.0));
    let cosine = 1.0 / tangent.hypot(1.0);
    let sine = tangent * cosine;
    rotation.col_mut(p)[p] = cosine;
    rotation.col_mut(q)[q] = cosine;
    rotation.col_mut(q)[p] = sine;
    rotation.col_mut(p)[q] = -sine;
    rotation
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud(n: u32) -> Vec<[f32; 3]> {
        (0..n)
            .map(|i| {
                [3.0 * (f64::from(i)).sin(), f64::from(i * i).cos(), 0.3 * f64::from(7 * i).sin()].map(|x| x as f32)
            })
            .collect()
    }

    #[test]
    fn axes_are_orthonormal_and_spread_falls() {
        let offsets: Vec<DVec3> = cloud(40).into_iter().map(|p| Vec3::from(p).as_dvec3()).collect();
        let axes = principal_axes(&offsets);
        let mean = offsets.iter().sum::<DVec3>() / 40.0;
        let moment = |a: DVec3, b: DVec3| offsets.iter().map(|o| a.dot(*o - mean) * b.dot(*o - mean)).sum::<f64>();
        for i in 0..3 {
            for j in 0..3 {
                assert!((axes[i].dot(axes[j]) - f64::from(u8::from(i == j))).abs() < 1e-12);
                assert!(i == j || moment(axes[i], axes[j]).abs() < 1e-9 * moment(axes[0], axes[0]));
            }
        }
        assert!(moment(axes[0], axes[0]) > moment(axes[1], axes[1]));
        assert!(moment(axes[1], axes[1]) > moment(axes[2], axes[2]));
    }

    #[test]
    fn few_points_are_all_candidates() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0]];
        assert_eq!(Neighbourhoods::new(&points).candidates(1), [1, 0, 2]);
    }

    #[test]
    fn a_turned_cloud_is_seen_alike() {
        let points = cloud(90);
        let turn = glam::Mat3::from_euler(glam::EulerRot::XYZ, 0.3, 1.1, 2.0);
        let turned: Vec<[f32; 3]> = points.iter().map(|&p| (2.0 * (turn * Vec3::from(p)) + 5.0).to_array()).collect();
        let seen = |points: &[[f32; 3]]| {
            let around = Neighbourhoods::new(points);
            around.places(&[around.candidates(7)], &[around.frame(7)])
        };
        let [a, b] = [seen(&points), seen(&turned)];
        assert!(a.data().iter().zip(b.data()).all(|(a, b)| (a - b).abs() < 1e-4));
    }
}
