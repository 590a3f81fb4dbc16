//! Simplification of one block of a mesh.

use crate::mesh::TriMesh;
use crate::model::Weights;

use super::closed::{ClosedRequest, ClosedResult, Levels, Task, simplify_levels};
use super::input::Input;
use super::limits::Limit;
use super::options::{ClosedOptions, Purpose, SimplifyError};
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
    weights: Option<&Weights>,
    options: &ClosedOptions,
) -> Result<SimplifiedBlock, SimplifyError> {
    // A closed surface needs four vertices.
    let limit = Limit::from_vertices(n_vertices.max(4));
    let ClosedOptions { scores, optimize, effort, crease_angle, purpose, frame, .. } = *options;
    let used = ClosedOptions {
        scores,
        optimize,
        effort,
        crease_angle,
        purpose,
        frame,
        prune: false,
        // Locked vertices may leave a block larger than its share; the joined mesh is simplified again.
        hold_shape: Some(f64::INFINITY),
        ..ClosedOptions::default()
    };
    let input = Input { locked, ..Input::bare(mesh) };
    let mut request = ClosedRequest { price, ..ClosedRequest::new(&input, &Task::new(&used, weights)) };
    // The purpose decides about scores only.
    request.requirements.purpose = Purpose::Shape;
    let levels = simplify_levels(mesh, &request, Levels::new(&[limit]), Progress::SILENT)?;
    let ClosedResult { simplified, pass_prices, .. } = levels.results.into_iter().next().ok_or(SimplifyError::Empty)?;
    Ok(SimplifiedBlock { mesh: simplified.mesh, pass_prices })
}
