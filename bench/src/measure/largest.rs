//! The largest distance between two meshes, as every page gives it.

use anyhow::{Context, Result};
use neural_mesh::mesh::TriMesh;
use neural_mesh::metrics::largest_distance;

/// No point of either is farther from the other, in the mesh's unit, and some is within 1 %.
pub fn largest(original: &TriMesh, simplified: &TriMesh) -> Result<f64> {
    largest_distance(original, simplified).context("no faces, or too many that lie across each other")
}
