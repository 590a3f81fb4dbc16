//! The largest distance between two meshes, as every page gives it.

use anyhow::{Context, Result};
use neural_mesh::mesh::TriMesh;
use neural_mesh::metrics::{Sharpness, certified_distance};

/// No point of either is farther from the other, in the mesh's unit, and some is within 1 %.
pub fn largest(original: &TriMesh, simplified: &TriMesh) -> Result<f64> {
    Ok(certified_distance(original, simplified, &Sharpness::default()).context("no faces")?.upper)
}
