//! Figures of the surfaces' position and orientation.

use super::figure::Figure;
use super::reference_mesh::ReferenceMesh;
use crate::mesh::TriMesh;
use crate::metrics::{Surface, chamfer, curvature_error, largest_distance, n_turned_faces, surface_distance};

/// Returns the figures of distance, normals and curvature.
pub fn figures(original: &ReferenceMesh, simplified: &TriMesh, surface: &Surface) -> [Figure; 9] {
    let share = 100.0 / original.surface.diagonal;
    let chamfer = chamfer(&original.surface.samples, &surface.samples).map(|cd| cd.sum() * (0.01 * share).powi(2));
    let both = surface_distance(&original.surface, surface).map(|distance| distance.both);
    let largest = largest_distance(&original.mesh, simplified);
    let turned = n_turned_faces(&original.surface, simplified).map(|n| n as f64);
    let curvature = curvature_error(original.mesh.positions(), simplified.positions());
    let percent = |distance: Option<f64>| distance.map(|distance| distance * share);
    let values = [
        chamfer,
        percent(both.map(|d| d.mean)),
        percent(both.map(|d| d.rms)),
        percent(largest),
        both.map(|d| d.unsigned_normal_error),
        both.map(|d| d.normal_error),
        both.map(|d| d.normal_angle.to_degrees()),
        turned,
        curvature,
    ];
    std::array::from_fn(|k| {
        let (name, unit, about) = FIGURES[k];
        Figure::new(name, unit, about, values[k])
    })
}

/// Names, units and descriptions of the figures, in their order.
const FIGURES: [(&str, &str, &str); 9] = [
    (
        "chamfer",
        "diagonal^2",
        "Chamfer distance between samples of both surfaces: mean squared distance, sum of both directions (the paper's CD)",
    ),
    ("distance_mean", "% of diagonal", "mean distance between the surfaces, in both directions"),
    ("distance_rms", "% of diagonal", "root mean square distance between the surfaces, in both directions"),
    (
        "distance_max",
        "% of diagonal",
        "largest distance between the surfaces (Hausdorff): a proved upper bound, at most 1 % above the true distance",
    ),
    ("normal_error", "", "mean of 1 - |n.n'| between normals at closest points (the paper's NE)"),
    ("normal_error_signed", "", "mean of 1 - n.n' between normals at closest points, which also counts turned faces"),
    ("normal_angle", "degrees", "mean angle between normals at closest points"),
    ("turned_faces", "faces", "faces whose normal opposes the original surface"),
    ("curvature_error", "", "squared error of the curvature at vertices, sum of both directions"),
];
