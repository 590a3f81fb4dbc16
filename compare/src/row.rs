//! One line of the table: a mesh, what was asked, by which method, and every figure of the outcome.

use std::path::Path;

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};

/// Distances are shares of the diagonal of the input's bounding box.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    pub mesh: String,
    /// Share of the vertices asked for; 1 for the input itself.
    pub ratio: f64,
    pub seed: u64,
    /// `input`, `ours` or `meshoptimizer`.
    pub method: String,
    pub vertices: usize,
    pub faces: usize,
    /// `reached`, or what stopped the method.
    pub outcome: String,
    pub vertices_after_pass: Option<usize>,
    /// Median over the repeats, one thread.
    pub seconds: f64,
    pub mean: f64,
    pub rms: f64,
    pub hausdorff: f64,
    /// Mean of 1 - n.n'.
    pub normal_error: f64,
    pub closed: bool,
    pub boundary_edges: usize,
    pub boundary_loops: usize,
    pub non_manifold_edges: usize,
    pub non_manifold_vertices: usize,
    pub inconsistent_edges: usize,
    pub components: usize,
    pub genus: Option<usize>,
    pub self_intersecting_faces: usize,
    pub turned_faces: usize,
}

impl Row {
    /// Whether both rows stand for the same mesh, ratio, seed and method.
    pub fn same_case(&self, mesh: &str, ratio: f64, seed: u64, method: &str) -> bool {
        self.mesh == mesh && self.ratio == ratio && self.seed == seed && self.method == method
    }
}

/// All rows of a table; none where the file does not exist.
pub fn read(path: &Path) -> Result<Vec<Row>> {
    if !path.exists() {
        return Ok(Vec::new());
    }
    let mut reader = csv::Reader::from_path(path)?;
    reader.deserialize().map(|row| row.with_context(|| format!("a row of {}", path.display()))).collect()
}

/// Writes the table, whole or not at all.
pub fn write(path: &Path, rows: &[Row]) -> Result<()> {
    let temporary = path.with_extension("partial");
    let mut writer = csv::Writer::from_path(&temporary)?;
    for row in rows {
        writer.serialize(row)?;
    }
    writer.flush()?;
    Ok(std::fs::rename(&temporary, path)?)
}
