//! A surface with its Laplacian, eigenpairs and geodesic solver.

use glam::DVec3;

use crate::along_surface::spectrum::HeatMethod;
use crate::along_surface::{Eigenpairs, Laplacian};
use neural_mesh::mesh::TriMesh;

// Largest number of eigenpairs that the paper compares.
const EIGENPAIRS: usize = 200;

/// Options of the figures along the surface: eigenpairs and geodesic distances.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IntrinsicOptions {
    /// Largest number of eigenpairs; 0 skips the figures that need them.
    pub eigenpairs: usize,
    /// True to measure geodesic distances.
    pub geodesics: bool,
    /// Vertex of the original where distances start; by default the one farthest from the box's centre.
    pub source: Option<u32>,
}

impl IntrinsicOptions {
    /// Options that measure no figure along the surface.
    pub const NONE: Self = Self { eigenpairs: 0, geodesics: false, source: None };
}

impl Default for IntrinsicOptions {
    fn default() -> Self {
        Self { eigenpairs: EIGENPAIRS, geodesics: true, source: None }
    }
}

pub struct IntrinsicSurface {
    pub laplacian: Laplacian,
    pub points: Vec<DVec3>,
    pub heat: Option<HeatMethod>,
    pub pairs: Option<Eigenpairs>,
}

impl IntrinsicSurface {
    pub fn new(mesh: &TriMesh, options: &IntrinsicOptions, n_target: usize) -> Option<Self> {
        if options.eigenpairs == 0 && !options.geodesics {
            return None;
        }
        let laplacian = Laplacian::new(mesh)?;
        let n_pairs = options.eigenpairs.min(n_target / 4);
        let point = |&v: &u32| DVec3::from_array(mesh.positions()[v as usize].map(f64::from));
        Some(Self {
            points: laplacian.vertices.iter().map(point).collect(),
            heat: if options.geodesics { HeatMethod::new(&laplacian) } else { None },
            pairs: if n_pairs > 0 { Eigenpairs::compute_lowest(&laplacian, n_pairs) } else { None },
            laplacian,
        })
    }

    pub fn nearest(&self, p: DVec3) -> u32 {
        let distance = |&i: &u32| self.points[i as usize].distance_squared(p);
        (0..self.points.len() as u32).min_by(|i, j| distance(i).total_cmp(&distance(j))).unwrap_or(0)
    }
}
