//! One block of a mesh, simplified up to a price that holds for all blocks, while what it shares with others stays.

use crate::mesh::{Attributes, TriMesh};
use crate::model::Weights;

use super::assemblies::{importance_by, score_source};
use super::closed::{Aim, Closed, Keep, Request, simplify_levels};
use super::input::kept_edges;
use super::limits::Limit;
use super::options::{Options, Parts, SimplifyError};
use super::progress::Progress;

/// What became of a block.
pub(crate) struct Piece {
    /// The lighter block.
    pub mesh: TriMesh,
    /// How many vertices rounds of merges left, falling, and up to which price each went: squared distance times area, in the unit of the
    /// mesh.
    pub paid: Vec<(usize, f64)>,
}

/// Simplifies a block to about `n_vertices`, or where a price is given, as long as merges cost no more. Locked vertices, n_input, keep every bit.
pub(crate) fn simplify_piece(
    mesh: &TriMesh,
    locked: &[bool],
    (n_vertices, price): (usize, Option<f64>),
    weights: Option<&Weights>,
    options: &Options,
) -> Result<Piece, SimplifyError> {
    let limit = Limit::of_vertices(n_vertices.max(4));
    let aim = Aim::of(options.optimize, options.effort);
    let request = Request {
        importance: importance_by(&[], score_source(options, &aim, weights), weights),
        hidden: &[],
        aim,
        parts: Parts::default(),
        frame: options.frame,
        differentiable: false,
        keep: Keep { edges: &kept_edges(mesh, Attributes::NONE, options), locked, ..Keep::default() },
        insists_on_size: false,
        price,
    };
    let levels = simplify_levels(mesh, &request, &[limit], None, Progress::UNHEARD)?;
    let Closed { mesh, paid, .. } = levels.made.into_iter().next().ok_or(SimplifyError::Empty)?;
    Ok(Piece { mesh, paid })
}
