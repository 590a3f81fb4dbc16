//! Simplification of one block of a mesh.

use crate::mesh::{Attributes, TriMesh};
use crate::model::Weights;

use super::assemblies::{choose_importance, score_source};
use super::closed::{ClosedRequest, ClosedResult, Requirements, StageSettings, simplify_levels};
use super::input::kept_edges;
use super::limits::Limit;
use super::options::{ClosedOptions, Refinements, SimplifyError};
use super::progress::Progress;

pub(crate) struct SimplifiedBlock {
    pub mesh: TriMesh,
    /// Vertices left by each pass that merged some, and its highest price, in mesh units to the fourth power.
    pub pass_prices: Vec<(usize, f64)>,
}

/// Simplifies a block to about `n_vertices`, or by merges up to a `price`; locked vertices keep every bit.
pub(crate) fn simplify_block_mesh(
    mesh: &TriMesh,
    locked: &[bool],
    (n_vertices, price): (usize, Option<f64>),
    weights: Option<&Weights>,
    options: &ClosedOptions,
) -> Result<SimplifiedBlock, SimplifyError> {
    // A closed surface needs four vertices.
    let limit = Limit::from_vertices(n_vertices.max(4));
    let settings = StageSettings::new(options.optimize, options.effort);
    let request = ClosedRequest {
        importance: choose_importance(&[], score_source(options, &settings, weights), weights),
        hidden: &[],
        settings,
        refinements: Refinements::default(),
        frame: options.frame,
        differentiable: false,
        requirements: Requirements {
            edges: &kept_edges(mesh, Attributes::NONE, options),
            locked,
            ..Requirements::default()
        },
        forces_size: false,
        price,
    };
    let levels = simplify_levels(mesh, &request, &[limit], None, Progress::SILENT)?;
    let ClosedResult { mesh, pass_prices, .. } = levels.results.into_iter().next().ok_or(SimplifyError::Empty)?;
    Ok(SimplifiedBlock { mesh, pass_prices })
}
