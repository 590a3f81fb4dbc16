//! The largest result within a number of bytes.

use crate::simplify::{Assembly, Input, Listener, Options, Outcome, Simplified, SimplifyError, Size, simplify};

use super::progress::Search;

/// Largest number of trials in a search.
const MOST_TRIES: usize = 8;
/// Share of the allowed bytes from which a result is large enough.
const FULL: f64 = 0.99;
/// Vertices of the first trial, which shows the bytes per vertex.
const FIRST: usize = 1000;
/// Failed trials in a row after which the smallest possible result is tried.
const MOST_MISSES: usize = 5;
/// Share of a trial's progress that simplification takes; writing takes the rest.
const SHARE_OF_RUN: f32 = 0.9;

/// Finds a result that takes at most `n_bytes` when written and nearly fills them.
///
/// `bytes_of` returns the bytes that a result takes. If no result fits, returns the smallest one with
/// [`Outcome::Stopped`].
///
/// # Errors
/// As [`simplify`], and those of `bytes_of`.
///
/// ```
/// use std::ops::ControlFlow;
/// use neural_mesh::{mesh::shapes, search::simplify_to_size};
/// use neural_mesh::simplify::{Assembly, ClosedOptions, Input, Simplified, SimplifyError};
/// let mesh = shapes::icosphere(5);
/// let bytes_of = |result: &Simplified| Ok::<_, SimplifyError>(500 + 26 * result.mesh.faces().len());
/// let go_on = &mut |_| ControlFlow::Continue(());
/// let closed = Assembly::Closed(ClosedOptions::default());
/// let found = simplify_to_size(&Input::bare(&mesh), &closed, 100_000, &bytes_of, go_on).unwrap();
/// assert!((98_000..=100_000).contains(&bytes_of(&found).unwrap()));
/// ```
pub fn simplify_to_size<E: From<SimplifyError>>(
    input: &Input,
    assembly: &Assembly,
    n_bytes: usize,
    bytes_of: &dyn Fn(&Simplified) -> Result<usize, E>,
    progress: &mut Listener,
) -> Result<Simplified, E> {
    let n_all = input.mesh.positions().len();
    let mut fits: Option<(Simplified, usize)> = None;
    let mut too_large: Option<(Simplified, usize)> = None;
    let mut vertices = FIRST.min(n_all);
    let mut search = Search::new(progress, SHARE_OF_RUN);
    for n_before in 0..MOST_TRIES {
        let options = Options::with_assembly(Size::Vertices(vertices), assembly.clone());
        let result = simplify(input, &options, &mut search.run())?;
        search.look("bytes")?;
        let n = bytes_of(&result)?;
        let is_last = n <= n_bytes && (vertices == n_all || n as f64 >= FULL * n_bytes as f64);
        // A constraint kept more vertices than requested, so smaller targets are useless.
        let is_held = n > n_bytes && result.mesh.positions().len() > vertices;
        *(if n <= n_bytes { &mut fits } else { &mut too_large }) = Some((result, n));
        if is_last || is_held {
            break;
        }
        let size = |known: &Option<(Simplified, usize)>| {
            known.as_ref().map(|(result, n)| (result.mesh.positions().len() as f64, *n as f64))
        };
        // The guess aims at the middle between `FULL` and the limit.
        let next = next_guess(size(&fits), size(&too_large), n_bytes as f64 * (0.5 + 0.5 * FULL));
        let is_hopeless = fits.is_none() && n_before + 1 >= MOST_MISSES;
        vertices = if is_hopeless { 1 } else { (next as usize).clamp(1, n_all) };
    }
    let outcome = outcome(fits.is_some(), too_large.as_ref());
    let (mut result, _) = fits.or(too_large).ok_or(SimplifyError::Empty)?;
    result.report.outcome = outcome;
    Ok(result)
}

fn outcome(fits: bool, too_large: Option<&(Simplified, usize)>) -> Outcome {
    let Some((result, n)) = too_large.filter(|_| !fits) else { return Outcome::Reached };
    let why = match &result.report.outcome {
        Outcome::Reached => String::new(),
        Outcome::Stopped(why) => format!(": {why}"),
    };
    Outcome::Stopped(format!("the smallest result takes {n} bytes{why}"))
}

/// Interpolates the number of vertices for `n_bytes` from a small and a large result (vertices, bytes).
fn next_guess(small: Option<(f64, f64)>, large: Option<(f64, f64)>, n_bytes: f64) -> f64 {
    match (small, large) {
        (Some((v, n)), Some((w, m))) if m > n => v + (w - v) * (n_bytes - n) / (m - n),
        (Some((v, n)), _) | (None, Some((v, n))) => v * n_bytes / n,
        (None, None) => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ops::ControlFlow;

    use crate::mesh::shapes;
    use crate::simplify::ClosedOptions;

    fn simplify_to_bytes(more: usize, n_bytes: usize) -> (Simplified, usize) {
        let mesh = shapes::icosphere(4);
        let bytes_of = |result: &Simplified| Ok::<_, SimplifyError>(more + 26 * result.mesh.faces().len());
        let (closed, go_on) = (Assembly::Closed(ClosedOptions::default()), &mut |_| ControlFlow::Continue(()));
        let result = simplify_to_size(&Input::bare(&mesh), &closed, n_bytes, &bytes_of, go_on).unwrap();
        let n = bytes_of(&result).unwrap();
        (result, n)
    }

    #[test]
    fn what_does_not_fit_is_said() {
        let (result, n) = simplify_to_bytes(0, 100);
        let Outcome::Stopped(why) = &result.report.outcome else { panic!("{n}") };
        assert!(n > 100 && why.starts_with(&format!("the smallest result takes {n} bytes: ")), "{why}");
        assert!(matches!(simplify_to_bytes(50_000, 50_000).0.report.outcome, Outcome::Stopped(_)));
    }

    #[test]
    fn a_size_is_met_even_if_most_bytes_are_constant() {
        for (more, n_bytes) in [(0, 20_000), (100_000, 102_000), (1_000_000, 1_000_500), (0, usize::MAX)] {
            let (result, n) = simplify_to_bytes(more, n_bytes);
            assert_eq!(result.report.outcome, Outcome::Reached, "{more} {n_bytes} {n}");
            assert!(n <= n_bytes);
        }
    }
}
