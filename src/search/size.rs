//! The largest result within a number of bytes.

use crate::simplify::{Assembly, Input, Listener, Options, Outcome, Simplified, SimplifyError, Size, simplify};

use super::progress::Search;

/// Largest number of trials in a search.
const MOST_TRIES: usize = 12;
/// Share of the allowed bytes from which a result is large enough.
const FULL: f64 = 0.99;
/// Share of the vertices of a trial that does not fit, below which a smaller one that fits is not near it.
const NEAR: f64 = 0.995;
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
    let mut trials = Trials { n_bytes, fits: None, too_large: None, n_alike: 0 };
    let mut vertices = FIRST.min(n_all);
    let mut search = Search::new(progress, SHARE_OF_RUN);
    for n_before in 0..MOST_TRIES {
        let options = Options::with_assembly(Size::Vertices(vertices), assembly.clone());
        let result = simplify(input, &options, &mut search.run())?;
        search.look("bytes")?;
        let n_bytes = bytes_of(&result)?;
        // A constraint kept more vertices than requested, so smaller targets are useless. Vertices that are split to
        // make a manifold are none.
        let is_held = matches!(result.report.outcome, Outcome::Stopped(_)) && result.mesh.positions().len() > vertices;
        let is_fit = trials.add(Trial { vertices, n_bytes, result });
        let is_end = if is_fit { vertices == n_all } else { is_held || vertices == 1 };
        if is_end || trials.are_near() {
            break;
        }
        let is_hopeless = trials.fits.is_none() && n_before + 1 >= MOST_MISSES;
        vertices = if is_hopeless { 1 } else { trials.next_vertices().clamp(1, n_all) };
    }
    let Trials { fits, too_large, .. } = trials;
    let outcome = outcome(fits.is_some(), too_large.as_ref());
    let mut result = fits.or(too_large).ok_or(SimplifyError::Empty)?.result;
    result.report.outcome = outcome;
    Ok(result)
}

struct Trial {
    /// Number of vertices that was asked for.
    vertices: usize,
    n_bytes: usize,
    result: Simplified,
}

/// The nearest trials on both sides of a number of bytes.
struct Trials {
    n_bytes: usize,
    /// The largest that fits.
    fits: Option<Trial>,
    /// The smallest that does not.
    too_large: Option<Trial>,
    /// Number of last trials on one side.
    n_alike: usize,
}

impl Trials {
    /// Adds a trial, and returns whether it fits.
    fn add(&mut self, trial: Trial) -> bool {
        let is_fit = trial.n_bytes <= self.n_bytes;
        let (own, other) = if is_fit { (&mut self.fits, &self.too_large) } else { (&mut self.too_large, &self.fits) };
        self.n_alike = if own.is_some() || other.is_none() { self.n_alike + 1 } else { 1 };
        *own = Some(trial);
        is_fit
    }

    /// Returns whether the trial that fits is large enough, or about as large as the other.
    fn are_near(&self) -> bool {
        let Some(fits) = &self.fits else { return false };
        let is_next =
            |other: &Trial| other.vertices <= fits.vertices + 1 || fits.vertices as f64 >= NEAR * other.vertices as f64;
        fits.n_bytes as f64 >= FULL * self.n_bytes as f64 || self.too_large.as_ref().is_some_and(is_next)
    }

    /// Interpolates the number of vertices, or halves what is between both sides where that has not come nearer.
    fn next_vertices(&self) -> usize {
        // The guess aims at the middle between `FULL` and the limit.
        let n_bytes = self.n_bytes as f64 * (0.5 + 0.5 * FULL);
        let by_share = |it: &Trial| (it.vertices as f64 * n_bytes / it.n_bytes.max(1) as f64) as usize;
        match (&self.fits, &self.too_large) {
            (Some(fits), Some(other)) => {
                let between = other.vertices - fits.vertices;
                let share = (n_bytes - fits.n_bytes as f64) / (other.n_bytes as f64 - fits.n_bytes as f64);
                // Bytes jump where a material goes, with its images.
                let share = if self.n_alike > 1 { 0.5 } else { share };
                fits.vertices + ((between as f64 * share) as usize).clamp(1, between - 1)
            }
            (Some(fits), None) => by_share(fits).max(fits.vertices + 1),
            (None, Some(other)) => by_share(other).min(other.vertices - 1),
            (None, None) => 1,
        }
    }
}

fn outcome(fits: bool, too_large: Option<&Trial>) -> Outcome {
    let Some(Trial { result, n_bytes, .. }) = too_large.filter(|_| !fits) else { return Outcome::Reached };
    let why = match &result.report.outcome {
        Outcome::Reached => String::new(),
        Outcome::Stopped(why) => format!(": {why}"),
    };
    Outcome::Stopped(format!("the smallest result takes {n_bytes} bytes{why}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ops::ControlFlow;

    use crate::mesh::{TriMesh, shapes};
    use crate::simplify::ClosedOptions;

    /// Returns a result whose bytes are those of its number of faces, and how many they are.
    fn simplify_by(mesh: &TriMesh, bytes: impl Fn(usize) -> usize, n_bytes: usize) -> (Simplified, usize) {
        let bytes_of = |result: &Simplified| Ok::<_, SimplifyError>(bytes(result.mesh.faces().len()));
        let (closed, go_on) = (Assembly::Closed(ClosedOptions::default()), &mut |_| ControlFlow::Continue(()));
        let result = simplify_to_size(&Input::bare(mesh), &closed, n_bytes, &bytes_of, go_on).unwrap();
        let n = bytes(result.mesh.faces().len());
        (result, n)
    }

    fn simplify_to_bytes(more: usize, n_bytes: usize) -> (Simplified, usize) {
        simplify_by(&shapes::icosphere(4), |n_faces| more + 26 * n_faces, n_bytes)
    }

    #[test]
    fn what_does_not_fit_is_said() {
        let (result, n) = simplify_to_bytes(0, 100);
        let Outcome::Stopped(why) = &result.report.outcome else { panic!("{n}") };
        assert!(n > 100 && why.starts_with(&format!("the smallest result takes {n} bytes: ")), "{why}");
        assert!(matches!(simplify_to_bytes(50_000, 50_000).0.report.outcome, Outcome::Stopped(_)));
    }

    #[test]
    fn vertices_that_are_split_hold_no_size() {
        let mesh = shapes::touching_spheres(2);
        let n_bytes = 26 * mesh.faces().len() / 2;
        let (result, n) = simplify_by(&mesh, |n_faces| 26 * n_faces, n_bytes);
        assert!(result.report.outcome == Outcome::Reached && n <= n_bytes && 100 * n >= 95 * n_bytes, "{n} {n_bytes}");
    }

    #[test]
    fn the_largest_that_fits_is_found_also_where_bytes_jump() {
        let mesh = shapes::icosphere(4);
        for (jump, n_bytes) in [(700, 220_000), (700, 300_000), (2500, 60_000), (4000, 250_000)] {
            let bytes = |n_faces: usize| 26 * n_faces + if n_faces > jump { 200_000 } else { 0 };
            let (result, _) = simplify_by(&mesh, bytes, n_bytes);
            let (n, best) = (result.mesh.faces().len(), (4..=5120).rev().find(|&n| bytes(n) <= n_bytes).unwrap());
            assert!(n <= best && 100 * n >= 95 * best, "{jump} {n_bytes}: {n} {best}");
        }
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
