//! The original mesh, made ready once to judge many simplified ones.

use glam::DVec3;

use crate::mesh::{Topology, TriMesh, topology};
use crate::metrics::spectrum::HeatMethod;
use crate::metrics::{Eigenpairs, Laplacian, Surface, volume};

/// Eigenpairs of the Laplacian that the paper compares, at most.
const EIGENPAIRS: usize = 200;

/// What is measured, and from how many samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Judging {
    /// Samples on each surface; the paper's 50 thousand by default.
    pub samples: usize,
    /// Decides where the samples lie; those of the simplified mesh are drawn with the next one.
    pub seed: u64,
    /// Eigenpairs of the Laplacian, at most a quarter of the vertices; 0 leaves out LE and biharmonic distances, which
    /// cost more than all other figures.
    pub eigenpairs: usize,
    /// Whether distances along the surface are measured.
    pub geodesics: bool,
    /// Vertex of the original from which distances along the surface are measured; by default, or where no face uses it,
    /// the one farthest from the middle of the bounding box.
    pub source: Option<u32>,
}

impl Default for Judging {
    fn default() -> Self {
        Self { samples: 50_000, seed: 0, eigenpairs: EIGENPAIRS, geodesics: true, source: None }
    }
}

/// The original, made ready once to judge many simplified meshes.
pub struct Original {
    pub(super) mesh: TriMesh,
    pub(super) judging: Judging,
    pub(super) surface: Surface,
    pub(super) topology: Topology,
    pub(super) volume: Option<f64>,
    pub(super) intrinsic: Option<Intrinsic>,
}

/// What is known of a surface from within.
pub struct Intrinsic {
    pub laplacian: Laplacian,
    /// Position of each vertex in use, n.
    pub points: Vec<DVec3>,
    pub heat: Option<HeatMethod>,
    pub pairs: Option<Eigenpairs>,
}

impl Original {
    /// Draws the samples, builds the trees, and solves for what [`Judging`] asks for.
    pub fn new(mesh: &TriMesh, judging: &Judging) -> Self {
        let topology = topology(mesh);
        Self {
            mesh: mesh.clone(),
            judging: *judging,
            surface: Surface::new(mesh, judging.samples, judging.seed),
            volume: volume(mesh, &topology),
            topology,
            intrinsic: Intrinsic::new(mesh, judging),
        }
    }

    /// Where the distances along the surface begin.
    pub(super) fn source(&self, points: &[DVec3]) -> DVec3 {
        let chosen = self.judging.source.and_then(|v| self.mesh.positions().get(v as usize));
        let low = points.iter().copied().reduce(DVec3::min).unwrap_or_default();
        let high = points.iter().copied().reduce(DVec3::max).unwrap_or_default();
        let middle = low.midpoint(high);
        let farthest = || points.iter().copied().max_by(|a, b| a.distance(middle).total_cmp(&b.distance(middle)));
        chosen.map(|p| DVec3::from_array(p.map(f64::from))).or_else(farthest).unwrap_or_default()
    }
}

impl Intrinsic {
    /// `None` where nothing of it is asked for, or the surface has no area.
    pub fn new(mesh: &TriMesh, judging: &Judging) -> Option<Self> {
        if judging.eigenpairs == 0 && !judging.geodesics {
            return None;
        }
        let laplacian = Laplacian::new(mesh)?;
        let n_pairs = judging.eigenpairs.min(laplacian.vertices.len() / 4);
        let point = |&v: &u32| DVec3::from_array(mesh.positions()[v as usize].map(f64::from));
        Some(Self {
            points: laplacian.vertices.iter().map(point).collect(),
            heat: if judging.geodesics { HeatMethod::new(&laplacian) } else { None },
            pairs: if n_pairs > 0 { Eigenpairs::lowest(&laplacian, n_pairs) } else { None },
            laplacian,
        })
    }

    /// Place of the vertex nearest to a point.
    pub fn nearest(&self, p: DVec3) -> u32 {
        let distance = |&i: &u32| self.points[i as usize].distance_squared(p);
        (0..self.points.len() as u32).min_by(|i, j| distance(i).total_cmp(&distance(j))).unwrap_or(0)
    }
}
