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
    /// Eigenpairs of the Laplacian, at most; 0 leaves out LE and biharmonic distances, which cost more than all other
    /// figures. [`Original::eigenpairs`] says how many are compared.
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
    /// What coordinates are multiplied with before anything is measured.
    pub(super) scale: f64,
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
        let scale = scale_to_one(mesh);
        let mesh = scaled(mesh, scale);
        let topology = topology(&mesh);
        Self {
            judging: *judging,
            surface: Surface::new(&mesh, judging.samples, judging.seed),
            volume: volume(&mesh),
            intrinsic: Intrinsic::new(&mesh, judging, topology.vertices - topology.unreferenced_vertices),
            topology,
            mesh,
            scale,
        }
    }

    /// Eigenpairs that are compared with a mesh that was asked to have so many vertices: as many as [`Judging`] allows, at
    /// most a quarter of the vertices asked for and of the original's in use, and those that the solver found.
    pub fn eigenpairs(&self, n_asked: usize) -> usize {
        let known = self.intrinsic.as_ref().and_then(|intrinsic| intrinsic.pairs.as_ref());
        known.map_or(0, |pairs| pairs.values.len().min(n_asked / 4))
    }

    /// Where the distances along the surface begin.
    pub(super) fn source(&self, points: &[DVec3]) -> DVec3 {
        let is_used = |v: &u32| self.mesh.faces().as_flattened().contains(v);
        let chosen = self.judging.source.filter(is_used).and_then(|v| self.mesh.positions().get(v as usize));
        let low = points.iter().copied().reduce(DVec3::min).unwrap_or_default();
        let high = points.iter().copied().reduce(DVec3::max).unwrap_or_default();
        let middle = low.midpoint(high);
        let farthest = || points.iter().copied().max_by(|a, b| a.distance(middle).total_cmp(&b.distance(middle)));
        chosen.map(|p| DVec3::from_array(p.map(f64::from))).or_else(farthest).unwrap_or_default()
    }
}

impl Intrinsic {
    /// With the eigenpairs that a mesh of so many vertices has; `None` where nothing of it is asked for, or the surface has
    /// no area.
    pub fn new(mesh: &TriMesh, judging: &Judging, n_asked: usize) -> Option<Self> {
        if judging.eigenpairs == 0 && !judging.geodesics {
            return None;
        }
        let laplacian = Laplacian::new(mesh)?;
        let n_pairs = judging.eigenpairs.min(n_asked / 4);
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

/// A power of two that brings a very small or very large mesh to about unit size, exactly; 1 for all others.
///
/// Squares and fourth powers of coordinates are taken in single precision in places: they must not run out of range.
fn scale_to_one(mesh: &TriMesh) -> f64 {
    let size = mesh.positions().as_flattened().iter().fold(0.0, |most: f32, x| most.max(x.abs()));
    let is_usual = size == 0.0 || (1e-6..=1e6).contains(&size);
    if is_usual { 1.0 } else { (-f64::from(size).log2().round()).exp2() }
}

/// The mesh with its coordinates multiplied; what would leave the range of numbers stays at its end.
pub(super) fn scaled(mesh: &TriMesh, by: f64) -> TriMesh {
    if by == 1.0 {
        return mesh.clone();
    }
    let coordinate = |x: f32| (f64::from(x) * by).clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32;
    let positions = mesh.positions().iter().map(|p| p.map(coordinate)).collect();
    TriMesh::new(positions, mesh.faces().to_vec()).unwrap_or_else(|_| mesh.clone())
}
