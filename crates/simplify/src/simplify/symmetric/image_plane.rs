//! Mirror planes and exact images in them.

use crate::mesh::{Frame, TriMesh};
use crate::simplify::Axis;
use crate::simplify::options::{MirrorPlane, Symmetry};
use crate::spatial::nearest_to;

/// Largest distance between a vertex and another's image, over the diagonal.
// Of 25 training meshes five are symmetric at this and at 1e-3, four at 1e-5, three at 1e-6.
const SAME: f64 = 1e-4;
const SAMPLES: usize = 4096;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ImagePlane {
    pub axis: usize,
    at: f32,
    step: f64,
}

impl ImagePlane {
    /// Rounds a plane to a grid on which coordinates up to `reach` have exact images.
    fn new(axis: usize, at: f64, reach: f64) -> Self {
        // On a grid of two bits less than single precision at the farthest coordinate, images are exact.
        let step = (reach.max(at.abs()).max(f64::from(f32::MIN_POSITIVE)).log2().floor() - 21.0).exp2();
        Self { axis, at: ((at / step).round() * step) as f32, step }
    }

    pub fn height(&self, p: [f32; 3]) -> f64 {
        f64::from(p[self.axis]) - f64::from(self.at)
    }

    /// Returns the image of a point; exact for points from [`Self::snap`].
    pub fn image(&self, mut p: [f32; 3]) -> [f32; 3] {
        p[self.axis] = (2.0 * f64::from(self.at) - f64::from(p[self.axis])) as f32;
        p
    }

    pub fn snap(&self, mut p: [f32; 3], on_plane: bool) -> [f32; 3] {
        // A vertex off the plane stays at least a step above it, so that it does not meet its image.
        let height = self.height(p).max(self.step);
        p[self.axis] = match on_plane {
            true => self.at,
            false if self.at == 0.0 => height as f32,
            false => (f64::from(self.at) + (height / self.step).round() * self.step) as f32,
        };
        p
    }

    pub fn touches(&self, p: [f32; 3]) -> bool {
        self.height(p).abs() <= self.step
    }

    pub fn in_file(&self, frame: &Frame) -> MirrorPlane {
        MirrorPlane { axis: Axis::ALL[self.axis], at: f64::from(self.at) + frame.origin[self.axis] }
    }
}

/// Finds the candidate planes in which the largest number of vertices have an image.
pub(super) fn find_planes(mesh: &TriMesh, symmetry: Symmetry, frame: &Frame) -> Vec<ImagePlane> {
    let across = |axis: Axis| candidates(mesh, axis.index(), frame);
    let mut planes: Vec<ImagePlane> = match symmetry {
        Symmetry::Best => Axis::ALL.into_iter().flat_map(across).collect(),
        Symmetry::Across(axis) => across(axis).to_vec(),
        Symmetry::Plane(MirrorPlane { axis, at }) => {
            let axis = axis.index();
            let (low, high) = extent(mesh, axis);
            vec![ImagePlane::new(axis, at - frame.origin[axis], low.abs().max(high.abs()))]
        }
    };
    let count_imaged = count_imaged(mesh, &planes);
    let most = count_imaged.iter().max();
    let mut are_best = count_imaged.iter().map(|n| Some(n) == most);
    planes.retain(|_| are_best.next().unwrap_or(false));
    planes.dedup();
    planes
}

pub(super) fn tolerance(mesh: &TriMesh) -> f64 {
    SAME * mesh.diagonal()
}

fn candidates(mesh: &TriMesh, axis: usize, frame: &Frame) -> [ImagePlane; 2] {
    let (low, high) = extent(mesh, axis);
    [-frame.origin[axis], 0.5 * (low + high)].map(|at| ImagePlane::new(axis, at, low.abs().max(high.abs())))
}

fn extent(mesh: &TriMesh, axis: usize) -> (f64, f64) {
    let along = mesh.positions().iter().map(|p| f64::from(p[axis]));
    along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
}

fn count_imaged(mesh: &TriMesh, planes: &[ImagePlane]) -> Vec<usize> {
    if planes.len() < 2 {
        return vec![0; planes.len()];
    }
    let positions = mesh.positions();
    let sample: Vec<[f32; 3]> = positions.iter().step_by(positions.len() / SAMPLES + 1).copied().collect();
    let images: Vec<[f32; 3]> = planes.iter().flat_map(|plane| sample.iter().map(|&p| plane.image(p))).collect();
    let nearest = nearest_to(positions, &images, 1);
    let tolerance = tolerance(mesh);
    let is_one = |(image, &v): (&[f32; 3], &u32)| is_within(*image, positions[v as usize], tolerance);
    let found: Vec<bool> = images.iter().zip(&nearest).map(is_one).collect();
    found.chunks(sample.len().max(1)).map(|found| found.iter().filter(|&&found| found).count()).collect()
}

pub(super) fn is_within(p: [f32; 3], q: [f32; 3], distance: f64) -> bool {
    let [p, q] = [p, q].map(|p| glam::Vec3::from(p).as_dvec3());
    p.distance_squared(q) <= distance * distance
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn images_of_images_are_the_points_wherever_the_plane_lies() {
        let mut state = 1u32;
        let mut random = || {
            state = state.wrapping_mul(1664525).wrapping_add(1013904223);
            (state >> 8) as f32 / 16777216.0
        };
        for (at, reach) in [(0.0, 1.0), (0.1, 3.0), (-700.3, 900.0), (1e-3, 1e-3), (5e6, 5e6), (1e-30, 2e-30)] {
            let plane = ImagePlane::new(1, at, reach);
            assert!((f64::from(plane.at) - at).abs() <= 1e-6 * reach);
            for _ in 0..1000 {
                let p = plane.snap([1.0, (at + reach * f64::from(random())) as f32, 2.0], false);
                let image = plane.image(p);
                assert!(plane.height(p) > 0.0 && plane.height(image) == -plane.height(p), "{at} {p:?} {image:?}");
                assert_eq!(plane.image(image), p);
                let on = plane.snap(p, true);
                assert_eq!(plane.image(on), on);
            }
        }
    }

    #[test]
    fn the_plane_is_found_at_zero_or_in_the_middle() {
        let box_ = shapes::cuboid([1.0, 2.0, 3.0], 4);
        let shift = |by: [f32; 3]| {
            let moved = box_.positions().iter().map(|p| std::array::from_fn(|k| p[k] + by[k])).collect();
            TriMesh::new(moved, box_.faces().to_vec()).unwrap()
        };
        let frame = Frame::default();
        let found = |mesh: &TriMesh, symmetry| find_planes(mesh, symmetry, &frame)[0].in_file(&frame);
        let y = Axis::Y;
        assert_eq!(found(&box_, Symmetry::Best), MirrorPlane { axis: Axis::X, at: 0.5 });
        assert_eq!(found(&shift([-0.5; 3]), Symmetry::Across(Axis::X)), MirrorPlane { axis: Axis::X, at: 0.0 });
        assert_eq!(found(&box_, Symmetry::Across(y)), MirrorPlane { axis: y, at: 1.0 });
        let far = Frame { origin: [100.0, 50.0, 0.0], double: true };
        let plane = find_planes(&shift([0.0, -1.0, 0.0]), Symmetry::Plane(MirrorPlane { axis: y, at: 50.0 }), &far)[0];
        assert_eq!((plane.at, plane.in_file(&far)), (0.0, MirrorPlane { axis: y, at: 50.0 }));
    }
}
