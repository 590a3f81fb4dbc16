//! The original mesh, made ready once to judge many simplified ones.

use super::judging::Judging;
use crate::mesh::{Topology, TriMesh, topology};
use crate::metrics::{Surface, volume};

/// The original, made ready once to judge many simplified meshes.
pub struct Original {
    pub(super) mesh: TriMesh,
    pub(super) judging: Judging,
    pub(super) surface: Surface,
    pub(super) topology: Topology,
    pub(super) volume: Option<f64>,
    /// What coordinates are multiplied with before anything is measured.
    scale: f64,
}

impl Original {
    /// Draws the samples and builds the trees.
    pub fn new(mesh: &TriMesh, judging: &Judging) -> Self {
        let scale = scale_to_one(mesh);
        let mesh = scaled(mesh, scale);
        let topology = topology(&mesh);
        Self {
            judging: *judging,
            surface: Surface::new(&mesh, judging.samples, judging.seed),
            volume: volume(&mesh),
            topology,
            mesh,
            scale,
        }
    }

    /// Returns a mesh as it is measured: a power of two brings very small and very large originals to about unit size.
    ///
    /// ```
    /// use neural_mesh::{mesh::{TriMesh, shapes}, metrics::{Judging, Original}};
    /// let tiny = shapes::icosphere(2).positions().iter().map(|p| p.map(|x| 2f32.powi(-80) * x)).collect();
    /// let tiny = TriMesh::new(tiny, shapes::icosphere(2).faces().to_vec()).unwrap();
    /// assert_eq!(Original::new(&tiny, &Judging::default()).scaled(&tiny), shapes::icosphere(2));
    /// ```
    pub fn scaled(&self, mesh: &TriMesh) -> TriMesh {
        scaled(mesh, self.scale)
    }
}

/// A power of two that brings a very small or very large mesh to about unit size, exactly; 1 for all others.
///
/// Squares and fourth powers of coordinates are taken in single precision in places: they must not run out of range.
fn scale_to_one(mesh: &TriMesh) -> f64 {
    let size = mesh.positions().as_flattened().iter().fold(0.0, |most: f32, x| most.max(x.abs()));
    let is_usual = size == 0.0 || (1e-6..=1e6).contains(&size);
    if is_usual { 1.0 } else { (-f64::from(size).log2().round()).exp2() }
}

/// The mesh with its coordinates multiplied; what would leave the range of numbers stays at its end.
fn scaled(mesh: &TriMesh, by: f64) -> TriMesh {
    if by == 1.0 {
        return mesh.clone();
    }
    let coordinate = |x: f32| (f64::from(x) * by).clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32;
    let positions = mesh.positions().iter().map(|p| p.map(coordinate)).collect();
    TriMesh::new(positions, mesh.faces().to_vec()).unwrap_or_else(|_| mesh.clone())
}
