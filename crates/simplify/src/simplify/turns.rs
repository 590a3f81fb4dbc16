//! Sizes that are made in turn, each chosen by the result before.

use super::options::Simplified;

/// A size that [`simplify_in_turn`](super::simplify_in_turn) makes next.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct NextSize {
    pub n_vertices: usize,
    /// True if only estimates of the distance at sizes on the way are wanted.
    pub is_estimate: bool,
}

/// A result or estimates of [`simplify_in_turn`](super::simplify_in_turn).
#[doc(hidden)]
pub enum Turn<'a> {
    Result(Box<Simplified>),
    /// Numbers of vertices, falling, and the largest distance then, in the mesh's unit; none where nothing estimates it.
    Estimates(&'a [(usize, f64)]),
}

/// Chooses the next size by what was made, or ends.
#[doc(hidden)]
pub type ChooseSize<'a> = dyn FnMut(Turn) -> Option<NextSize> + 'a;
