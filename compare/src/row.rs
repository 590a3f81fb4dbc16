//! One line of the main table: a mesh, what was asked, by which method, and every figure of the outcome.

use serde::{Deserialize, Serialize};

/// Distances are shares of the diagonal of the input's bounding box.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    pub mesh: String,
    /// Share of the vertices asked for; 1 for the input itself.
    pub ratio: f64,
    pub seed: u64,
    /// `input`, or who made the result.
    pub method: String,
    pub vertices: usize,
    pub faces: usize,
    /// `reached`, what stopped the method, or `failed:` and why there is no result.
    pub outcome: String,
    /// Vertices left by our one pass, before the collapse.
    pub vertices_after_pass: Option<usize>,
    /// Samples we drew per vertex asked for.
    pub oversample: Option<f64>,
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
    /// Whether the row stands for this mesh, ratio, seed and method.
    pub fn is_case(&self, mesh: &str, ratio: f64, seed: u64, method: &str) -> bool {
        self.mesh == mesh && self.ratio == ratio && self.seed == seed && self.method == method
    }

    /// Whether there is no result.
    pub fn failed(&self) -> bool {
        self.outcome.starts_with("failed")
    }
}
