//! Largest distance between two meshes.

use anyhow::{Context, Result};
use neural_mesh::mesh::TriMesh;
use neural_mesh::metrics::largest_distance;

/// Returns the Hausdorff distance in the mesh's unit: an upper bound, at most 1 % too large.
pub fn hausdorff_distance(original: &TriMesh, simplified: &TriMesh) -> Result<f64> {
    largest_distance(original, simplified).context("no faces, or too many that lie across each other")
}
