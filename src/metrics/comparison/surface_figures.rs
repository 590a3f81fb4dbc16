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
    let unit = "% of diagonal";
    let cd = "Chamfer distance between samples of both surfaces: mean squared distance, sum of both directions (the paper's CD)";
    let unsigned = "mean of 1 - |n.n'| between normals at closest points (the paper's NE)";
    let signed = "mean of 1 - n.n' between normals at closest points, which also counts turned faces";
    [
        Figure::new("chamfer", "diagonal^2", cd, chamfer),
        Figure::new(
            "distance_mean",
            unit,
            "mean distance between the surfaces, in both directions",
            both.map(|d| d.mean * share),
        ),
        Figure::new(
            "distance_rms",
            unit,
            "root mean square distance between the surfaces, in both directions",
            both.map(|d| d.rms * share),
        ),
        Figure::new(
            "distance_max",
            unit,
            "largest distance between the surfaces (Hausdorff): a proved upper bound, at most 1 % above the true distance",
            largest.map(|largest| largest * share),
        ),
        Figure::new("normal_error", "", unsigned, both.map(|d| d.unsigned_normal_error)),
        Figure::new("normal_error_signed", "", signed, both.map(|d| d.normal_error)),
        Figure::new(
            "normal_angle",
            "degrees",
            "mean angle between normals at closest points",
            both.map(|d| d.normal_angle.to_degrees()),
        ),
        Figure::new("turned_faces", "faces", "faces whose normal opposes the original surface", turned),
        Figure::new(
            "curvature_error",
            "",
            "squared error of the curvature at vertices, sum of both directions",
            curvature,
        ),
    ]
}
