//! Simplification of one block of a mesh.

use crate::mesh::TriMesh;

use super::closed::{ClosedRequest, ClosedResult, Task, simplify_to_limit};
use super::input::Input;
use super::limits::Limit;
use super::network_scores::used_scores;
use super::options::{ClosedOptions, Purpose, ScoreSource, SimplifyError};
use super::progress::Progress;

#[doc(hidden)]
pub struct SimplifiedBlock {
    pub mesh: TriMesh,
    /// Vertices left by each pass that merged some, and its highest price, in mesh units to the fourth power.
    pub pass_prices: Vec<(usize, f64)>,
}

/// Simplifies a block to about `n_vertices`, or by merges up to a `price`; locked vertices keep every bit.
#[doc(hidden)]
pub fn simplify_block_mesh(
    mesh: &TriMesh,
    locked: &[bool],
    (n_vertices, price): (usize, Option<f64>),
    scores: &[f32],
    options: &ClosedOptions,
) -> Result<SimplifiedBlock, SimplifyError> {
    // A closed surface needs four vertices.
    let limit = Limit::from_vertices(n_vertices.max(4));
    let input = Input { locked, scores, ..Input::bare(mesh) };
    let scores = used_scores(&input, options);
    let input = Input { scores: &scores, ..input };
    let has_scores = options.purpose == Purpose::Shape || !scores.is_empty();
    let used = ClosedOptions {
        // The purpose decides about scores only.
        scores: if has_scores { options.scores } else { ScoreSource::Geometry },
        purpose: Purpose::Shape,
        prune: false,
        prune_within: f64::INFINITY,
        // Locked vertices may leave a block larger than its share; the joined mesh is simplified again.
        hold_shape: Some(f64::INFINITY),
        lock_boundaries: false,
        subset: false,
        map: false,
        ..options.clone()
    };
    let request = ClosedRequest { price, ..ClosedRequest::new(Task::new(input, &used)) };
    let ClosedResult { simplified, pass_prices, .. } = simplify_to_limit(&request, limit, Progress::SILENT)?;
    Ok(SimplifiedBlock { mesh: simplified.mesh, pass_prices })
}
