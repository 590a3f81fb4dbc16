//! Simplification of one block of a mesh.

use crate::mesh::{Attributes, TriMesh};
use crate::model::Weights;

use super::assemblies::{choose_importance, score_source};
use super::closed::{Aim, Closed, ClosedRequest, Keep, simplify_levels};
use super::input::kept_edges;
use super::limits::Limit;
use super::options::{Options, Refinements, SimplifyError};
use super::progress::Progress;

pub(crate) struct SimplifiedBlock {
    pub mesh: TriMesh,
    /// Number of vertices after each pass, with its price in mesh units.
    pub paid: Vec<(usize, f64)>,
}

/// Simplifies a block to about `n_vertices`, or up to a price; locked vertices keep every bit.
pub(crate) fn simplify_block_mesh(
    mesh: &TriMesh,
    locked: &[bool],
    (n_vertices, price): (usize, Option<f64>),
    weights: Option<&Weights>,
    options: &Options,
) -> Result<SimplifiedBlock, SimplifyError> {
    // A closed surface needs four vertices.
    let limit = Limit::of_vertices(n_vertices.max(4));
    let aim = Aim::new(options.optimize, options.effort);
    let request = ClosedRequest {
        importance: choose_importance(&[], score_source(options, &aim, weights), weights),
        hidden: &[],
        aim,
        refinements: Refinements::default(),
        frame: options.frame,
        differentiable: false,
        keep: Keep { edges: &kept_edges(mesh, Attributes::NONE, options), locked, ..Keep::default() },
        insists_on_size: false,
        price,
    };
    let levels = simplify_levels(mesh, &request, &[limit], None, Progress::SILENT)?;
    let Closed { mesh, paid, .. } = levels.made.into_iter().next().ok_or(SimplifyError::Empty)?;
    Ok(SimplifiedBlock { mesh, paid })
}
