//! The original of a comparison.

use super::compare_options::CompareOptions;
use crate::mesh::{Topology, TriMesh, topology};
use crate::metrics::{Surface, volume};

/// An original, prepared for measuring many simplified meshes.
pub struct ReferenceMesh {
    pub(super) mesh: TriMesh,
    pub(super) options: CompareOptions,
    pub(super) surface: Surface,
    pub(super) topology: Topology,
    pub(super) volume: Option<f64>,
    scale: f64,
}

impl ReferenceMesh {
    /// Draws the samples and builds the trees.
    pub fn new(mesh: &TriMesh, options: &CompareOptions) -> Self {
        let scale = scale_to_one(mesh);
        let mesh = scale_by(mesh, scale);
        let topology = topology(&mesh);
        Self {
            options: *options,
            surface: Surface::new(&mesh, options.samples, options.seed),
            volume: volume(&mesh),
            topology,
            mesh,
            scale,
        }
    }

    /// Returns a mesh scaled by the power of two that brings the original to about unit size.
    ///
    /// ```
    /// # use neural_mesh_measure as neural_mesh;
    /// use neural_mesh::{mesh::{TriMesh, shapes}, metrics::{CompareOptions, ReferenceMesh}};
    /// let tiny = shapes::icosphere(2).positions().iter().map(|p| p.map(|x| 2f32.powi(-80) * x)).collect();
    /// let tiny = TriMesh::new(tiny, shapes::icosphere(2).faces().to_vec()).unwrap();
    /// assert_eq!(ReferenceMesh::new(&tiny, &CompareOptions::default()).to_unit_size(&tiny), shapes::icosphere(2));
    /// ```
    pub fn to_unit_size(&self, mesh: &TriMesh) -> TriMesh {
        scale_by(mesh, self.scale)
    }
}

fn scale_to_one(mesh: &TriMesh) -> f64 {
    let size = mesh.positions().as_flattened().iter().fold(0.0, |most: f32, x| most.max(x.abs()));
    let is_usual = size == 0.0 || (1e-6..=1e6).contains(&size);
    if is_usual { 1.0 } else { (-f64::from(size).log2().round()).exp2() }
}

fn scale_by(mesh: &TriMesh, by: f64) -> TriMesh {
    if by == 1.0 {
        return mesh.clone();
    }
    let coordinate = |x: f32| (f64::from(x) * by).clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32;
    let positions = mesh.positions().iter().map(|p| p.map(coordinate)).collect();
    TriMesh::new(positions, mesh.faces().to_vec()).unwrap_or_else(|_| mesh.clone())
}
