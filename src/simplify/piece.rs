//! One block of a mesh, simplified up to a price that holds for all blocks, while what it shares with others stays.

use crate::mesh::{Attributes, TriMesh};
use crate::model::Weights;

use super::closed::{Aim, Closed, Importance, Keep, Request, simplify_levels};
use super::input::kept_edges;
use super::limits::{Limit, oversample_of_pass, ratio};
use super::options::{Options, Parts, ScoreSource, SimplifyError};
use super::progress::Progress;

/// What became of a block.
pub(crate) struct Piece {
    /// The lighter block.
    pub mesh: TriMesh,
    /// How many vertices rounds of merges left, falling, and up to which price each went: squared distance times area, in the unit of the
    /// mesh.
    pub paid: Vec<(usize, f64)>,
}

/// Simplifies a block to about `n_vertices`, or where a price is given, as long as merges cost no more, with as many samples as that
/// number calls for. Locked vertices, n_input, keep every bit.
pub(crate) fn simplify_piece(
    mesh: &TriMesh,
    locked: &[bool],
    (n_vertices, price): (usize, Option<f64>),
    weights: Option<&Weights>,
    options: &Options,
) -> Result<Piece, SimplifyError> {
    let limit = Limit::of_vertices(n_vertices.max(4));
    let aim = Aim::of(options.optimize);
    let is_by_network = aim.strength > 0.0 && options.scores == ScoreSource::Network;
    let by_network = || Importance::Network(weights.unwrap_or_else(|| Weights::shipped_default()));
    let request = Request {
        oversample: oversample_of_pass(ratio(mesh, limit).min(1.0)),
        all_if_uneven: true,
        importance: if is_by_network { by_network() } else { Importance::Even },
        hidden: &[],
        aim,
        parts: Parts::default(),
        seed: options.seed,
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
