//! The largest result that fits into a number of bytes.

use crate::model::Weights;
use crate::simplify::{Input, Listener, Options, Simplified, SimplifyError, Target, simplify_input};

use super::part::part_of;

/// Results tried at most.
const MOST_TRIES: usize = 8;
/// A result that fills this share of the bytes is large enough.
const FULL: f64 = 0.99;
/// Vertices of the first, small try, which tells what a vertex takes.
const FIRST: usize = 1000;

/// Finds a result that takes at most `n_bytes` when it is written, as `bytes_of` says, and nearly fills them; the target of
/// `options` does not count. Where no result is small enough, the smallest that was made.
///
/// # Errors
/// As [`simplify_input`], and those of `bytes_of`.
///
/// ```
/// use std::ops::ControlFlow;
/// use neural_mesh::{mesh::shapes, search::simplify_to_size};
/// use neural_mesh::simplify::{Input, Options, Simplified, SimplifyError, Target};
/// let mesh = shapes::icosphere(5);
/// let bytes_of = |result: &Simplified| Ok::<_, SimplifyError>(500 + 26 * result.mesh.faces().len());
/// let go_on = &mut |_| ControlFlow::Continue(());
/// let options = Options::new(Target::Ratio(1.0));
/// let found = simplify_to_size(&Input::bare(&mesh), None, &options, 100_000, &bytes_of, go_on).unwrap();
/// assert!((98_000..=100_000).contains(&bytes_of(&found).unwrap()));
/// ```
pub fn simplify_to_size<E: From<SimplifyError>>(
    input: &Input,
    weights: Option<&Weights>,
    options: &Options,
    n_bytes: usize,
    bytes_of: &dyn Fn(&Simplified) -> Result<usize, E>,
    progress: &mut Listener,
) -> Result<Simplified, E> {
    let n_all = input.mesh.positions().len();
    let mut fits: Option<(Simplified, usize)> = None;
    let mut too_large: Option<(Simplified, usize)> = None;
    let mut vertices = FIRST.min(n_all);
    for n_before in 0..MOST_TRIES {
        let options = Options { target: Target::Vertices(vertices), ..options.clone() };
        let result = simplify_input(input, weights, &options, &mut part_of(progress, n_before, MOST_TRIES))?;
        let n = bytes_of(&result)?;
        let is_last = n <= n_bytes && (vertices == n_all || n as f64 >= FULL * n_bytes as f64);
        let is_held = n > n_bytes && result.mesh.positions().len() > vertices;
        *(if n <= n_bytes { &mut fits } else { &mut too_large }) = Some((result, n));
        if is_last || is_held {
            break;
        }
        let size = |known: &Option<(Simplified, usize)>| {
            known.as_ref().map(|(result, n)| (result.mesh.positions().len() as f64, *n as f64))
        };
        let next = next_guess(size(&fits), size(&too_large), n_bytes as f64 * (0.5 + 0.5 * FULL));
        vertices = (next as usize).clamp(1, n_all);
    }
    match fits.or(too_large) {
        Some((result, _)) => Ok(result),
        None => Err(SimplifyError::Empty.into()),
    }
}

/// Vertices for so many bytes, from what was measured of a small and a large result (vertices, bytes).
fn next_guess(small: Option<(f64, f64)>, large: Option<(f64, f64)>, n_bytes: f64) -> f64 {
    match (small, large) {
        (Some((v, n)), Some((w, m))) if m > n => v + (w - v) * (n_bytes - n) / (m - n),
        (Some((v, n)), _) | (None, Some((v, n))) => v * n_bytes / n,
        (None, None) => 1.0,
    }
}
