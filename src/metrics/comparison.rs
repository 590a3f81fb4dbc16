//! Everything that is said of a simplified mesh against its original, as one flat list of named figures.
//!
//! The order and the names of the figures are fixed, so that they can be columns of a table; what each one means is said
//! in `docs/metrics.md`. What a figure is made of stands in the files beside this one.

use super::{Surface, chamfer, curvature_error, open_edges, self_intersecting_faces, surface_distance, turned_faces};
use crate::mesh::{Topology, TriMesh, topology};

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
    /// Vertex of the original from which distances along the surface are measured; by default the one farthest from
    /// the middle of the bounding box.
    pub source: Option<u32>,
}

impl Default for Judging {
    fn default() -> Self {
        Self { samples: 50_000, seed: 0, eigenpairs: EIGENPAIRS, geodesics: true, source: None }
    }
}

/// The original, made ready once to judge many simplified meshes.
pub struct Original {
    mesh: TriMesh,
    judging: Judging,
    surface: Surface,
    topology: Topology,
}

impl Original {
    /// Draws the samples, builds the trees, and solves for what [`Judging`] asks for.
    pub fn new(mesh: &TriMesh, judging: &Judging) -> Self {
        Self {
            mesh: mesh.clone(),
            judging: *judging,
            surface: Surface::new(mesh, judging.samples, judging.seed),
            topology: topology(mesh),
        }
    }
}

/// One figure of a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    /// Name in snake case; never changes.
    pub name: &'static str,
    /// What the value counts in, such as "% of diagonal" or "degrees"; empty for plain numbers.
    pub unit: &'static str,
    /// What it is, in one sentence.
    pub about: &'static str,
    /// The value; `None` where it cannot be measured or was not asked for.
    pub value: Option<f64>,
}

/// Measures a simplified mesh against its original: always the same figures in the same order.
///
/// ```
/// use neural_mesh::{mesh::shapes, metrics::{Judging, Original, compare}};
/// let judging = Judging { samples: 1000, ..Judging::default() };
/// let original = Original::new(&shapes::icosphere(3), &judging);
/// let figures = compare(&original, &shapes::icosphere(2));
/// let distance = figures.iter().find(|figure| figure.name == "distance_mean").unwrap();
/// assert!(distance.value.unwrap() < 1.0 && distance.unit == "% of diagonal");
/// ```
pub fn compare(original: &Original, simplified: &TriMesh) -> Vec<Figure> {
    let surface = Surface::new(simplified, original.judging.samples, original.judging.seed + 1);
    let mut figures = Vec::new();
    figures.extend(distances(original, &surface));
    figures.extend(normals(original, &surface, simplified));
    figures.extend(curvature(original, simplified));
    figures.extend(edges(original, simplified));
    figures
}

fn figure(name: &'static str, unit: &'static str, about: &'static str, value: Option<f64>) -> Figure {
    Figure { name, unit, about, value }
}

fn distances(original: &Original, surface: &Surface) -> [Figure; 4] {
    let share = 100.0 / original.surface.diagonal;
    let chamfer = chamfer(&original.surface.samples, &surface.samples).map(|cd| cd.sum() * (0.01 * share).powi(2));
    let both = surface_distance(&original.surface, surface).map(|distance| distance.both);
    let about = "Chamfer distance between samples of both surfaces, squared (the paper's CD)";
    let unit = "% of diagonal";
    [
        figure("chamfer", "diagonal^2", about, chamfer),
        figure("distance_mean", unit, "mean distance between the surfaces, both ways", both.map(|d| d.mean * share)),
        figure("distance_rms", unit, "root mean square of that distance", both.map(|d| d.rms * share)),
        figure("distance_max", unit, "largest distance between the surfaces (Hausdorff)", both.map(|d| d.max * share)),
    ]
}

fn normals(original: &Original, surface: &Surface, simplified: &TriMesh) -> [Figure; 4] {
    let both = surface_distance(&original.surface, surface).map(|distance| distance.both);
    let turned = turned_faces(&original.surface, simplified).len() as f64;
    let unsigned = "mean of 1 - |n.n'| between normals at nearest points (the paper's NE)";
    let signed = "mean of 1 - n.n', which also sees faces turned over";
    [
        figure("normal_error", "", unsigned, both.map(|d| d.unsigned_normal_error)),
        figure("normal_error_signed", "", signed, both.map(|d| d.normal_error)),
        figure("normal_angle", "degrees", "mean angle between normals", both.map(|d| d.normal_angle.to_degrees())),
        figure("turned_faces", "faces", "faces that look against the original surface", Some(turned)),
    ]
}

fn curvature(original: &Original, simplified: &TriMesh) -> [Figure; 1] {
    let error = curvature_error(original.mesh.positions(), simplified.positions());
    [figure("curvature_error", "", "two-sided error of the vertices' curvature, squared", error)]
}

fn edges(original: &Original, simplified: &TriMesh) -> [Figure; 8] {
    let edges = open_edges(&original.mesh, simplified);
    let found = topology(simplified);
    let crossed = self_intersecting_faces(simplified).len();
    let count = |n: usize| Some(n as f64);
    let wa = "edges with one, three or more faces (the paper's WA)";
    let opened = "those of them that do not lie on a border of the original";
    let added = found.components as f64 - original.topology.components as f64;
    [
        figure("edges_without_two_faces", "% of edges", wa, Some(edges.wa_percent())),
        figure("open_edges", "% of edges", opened, Some(edges.open_percent())),
        figure("border_edges", "edges", "edges with one face", count(found.boundary_edges)),
        figure("non_manifold_edges", "edges", "edges with three or more faces", count(found.non_manifold_edges)),
        figure("non_manifold_vertices", "vertices", "vertices of several fans", count(found.non_manifold_vertices)),
        figure("flipped_edges", "edges", "edges whose faces disagree on the side", count(found.inconsistent_edges)),
        figure("self_intersecting_faces", "faces", "faces that cross another face", count(crossed)),
        figure("components_added", "", "pieces more than the original has", Some(added)),
    ]
}
