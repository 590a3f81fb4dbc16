//! The smallest result found whose distance from the original is proved to be small enough.

use crate::mesh::TriMesh;
use crate::metrics::{CertifiedDistance, Sharpness, certified_distance};
use crate::model::Weights;
use crate::simplify::{Input, Listener, Options, Simplified, SimplifyError, Target, simplify_levels_of_detail};

use super::part::part_of;

/// Sizes looked at in one go, from one collapse.
const SIZES: usize = 8;
/// Factor between the largest and the smallest of them while nothing is known yet.
const SPAN: f64 = 20.0;
/// Collapses at most.
const MOST_ROUNDS: usize = 5;
/// The search ends when a mesh smaller by this factor was too far from the original.
const CLOSE: f64 = 1.02;
/// Share of the vertices that the first level of a collapse keeps: so many that it begins with all of them. What the one pass
/// leaves out is missed by the largest distance before it is missed by the mean.
const WHOLE: f64 = 0.7;

/// A result and the proof.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounded {
    /// The result.
    pub simplified: Simplified,
    /// Bounds of its largest distance from the original, in either direction; the upper is at most what was asked.
    pub distance: CertifiedDistance,
    /// Results that were made.
    pub n_tries: usize,
}

/// Finds the smallest result whose two-sided largest distance from the mesh is certainly at most `error`, in the unit
/// of the mesh; the target of `options` does not count.
///
/// Distances nearly fall with size, not quite: some smaller mesh may hold the error too.
///
/// # Errors
/// As [`simplify_input`](crate::simplify::simplify_input); [`SimplifyError::BadError`] where `error` is negative or not a number.
///
/// ```
/// use std::ops::ControlFlow;
/// use neural_mesh::{mesh::shapes, search::simplify_to_error, simplify::{Input, Options, Target}};
/// let mesh = shapes::icosphere(4);
/// let options = Options::new(Target::Ratio(1.0));
/// let go_on = &mut |_| ControlFlow::Continue(());
/// let found = simplify_to_error(&Input::bare(&mesh), None, &options, 0.02, go_on).unwrap();
/// assert!(found.distance.upper <= 0.02 && found.simplified.mesh.faces().len() < 1000);
/// ```
pub fn simplify_to_error(
    input: &Input,
    weights: Option<&Weights>,
    options: &Options,
    error: f64,
    progress: &mut Listener,
) -> Result<Bounded, SimplifyError> {
    if error.is_nan() || error < 0.0 {
        return Err(SimplifyError::BadError(error));
    }
    let mut n_before = 0;
    let mut levels = |sizes: &[usize]| {
        let progress = &mut part_of(progress, n_before, MOST_ROUNDS + 1);
        n_before += 1;
        at_sizes(input, weights, options, sizes, progress)
    };
    let (best, n_tries) = smallest_that_holds(input.mesh, error, &mut levels)?;
    let is_proved = best.is_some();
    let simplified = match best {
        Some(best) => best,
        None => levels(&[input.mesh.positions().len()])?.pop().ok_or(SimplifyError::Empty)?,
    };
    // How far below the half it lies is of no interest, and takes long to say of flat parts.
    let asked = Sharpness { enough: 0.5 * error, ..Sharpness::default() };
    let sharp = certified_distance(input.mesh, &simplified.mesh, &asked).unwrap_or_default();
    let upper = if is_proved { sharp.upper.min(error) } else { sharp.upper };
    Ok(Bounded { simplified, distance: CertifiedDistance { upper, ..sharp }, n_tries })
}

/// Results with so many vertices, falling, from one collapse.
type Levels<'a> = dyn FnMut(&[usize]) -> Result<Vec<Simplified>, SimplifyError> + 'a;

fn at_sizes(
    input: &Input,
    weights: Option<&Weights>,
    options: &Options,
    sizes: &[usize],
    progress: &mut Listener,
) -> Result<Vec<Simplified>, SimplifyError> {
    let whole = (WHOLE * input.mesh.positions().len() as f64) as usize;
    let first = sizes.iter().copied().fold(whole, usize::max).max(1);
    let options = Options { target: Target::Vertices(first), ..options.clone() };
    let sizes: Vec<Target> = sizes.iter().map(|&size| Target::Vertices(size)).collect();
    let mut results = simplify_levels_of_detail(input, weights, &options, &sizes, progress)?;
    Ok(results.split_off(1))
}

/// The smallest result found that holds the error, if one does, and how many were made.
fn smallest_that_holds(
    original: &TriMesh,
    error: f64,
    levels: &mut Levels,
) -> Result<(Option<Simplified>, usize), SimplifyError> {
    let mut range = Range { too_few: 0, enough: original.positions().len() };
    let (mut best, mut n_tries) = (None, 0);
    for _ in 0..MOST_ROUNDS {
        let sizes = range.sizes();
        if range.is_narrow() || sizes.is_empty() {
            break;
        }
        let mut results = levels(&sizes)?;
        n_tries += results.len();
        let n_hold = holding(&results, |result| holds(original, &result.mesh, error));
        range.too_few = sizes.get(n_hold).copied().unwrap_or(range.too_few);
        if n_hold > 0 {
            results.truncate(n_hold);
            range.enough = sizes[n_hold - 1];
            best = results.pop();
        }
        // What is held by something else gets no smaller.
        if best.as_ref().is_some_and(|best: &Simplified| best.mesh.positions().len() > range.enough) {
            break;
        }
    }
    Ok((best, n_tries))
}

/// How many of the results, the largest first, hold what they have to, if all do that are larger than one that does.
fn holding(results: &[Simplified], holds: impl Fn(&Simplified) -> bool) -> usize {
    let (mut low, mut high) = (0, results.len());
    while low < high {
        let middle = low.midpoint(high);
        if holds(&results[middle]) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    low
}

/// Whether the largest distance is certainly at most `error`.
fn holds(original: &TriMesh, simplified: &TriMesh, error: f64) -> bool {
    let asked = Sharpness { enough: error, too_much: error, gap: 0.0 };
    certified_distance(original, simplified, &asked).is_some_and(|distance| distance.upper <= error)
}

/// Numbers of vertices: the most that were too few, the fewest that were enough.
struct Range {
    too_few: usize,
    enough: usize,
}

impl Range {
    fn is_narrow(&self) -> bool {
        self.enough as f64 <= (self.too_few as f64 * CLOSE).max(self.too_few as f64 + 1.0)
    }

    /// Sizes within, falling, evenly spaced by factors.
    fn sizes(&self) -> Vec<usize> {
        let high = self.enough as f64;
        let low = if self.too_few > 0 { self.too_few as f64 } else { (high / SPAN).max(1.0) };
        let step = if self.too_few > 0 { SIZES + 1 } else { SIZES };
        let size = |k: usize| (high * (low / high).powf(k as f64 / step as f64)).round() as usize;
        let mut sizes: Vec<usize> = (1..=SIZES).map(size).collect();
        sizes.retain(|&size| size > self.too_few && size < self.enough);
        sizes.dedup();
        sizes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ops::ControlFlow;

    use crate::mesh::{shapes, topology};
    use crate::metrics::{Surface, surface_distance};

    fn found(mesh: &TriMesh, error: f64) -> Bounded {
        let options = Options::new(Target::Ratio(1.0));
        simplify_to_error(&Input::bare(mesh), None, &options, error, &mut |_| ControlFlow::Continue(())).unwrap()
    }

    #[test]
    fn no_sample_is_farther_than_asked_and_fewer_vertices_would_be() {
        let mesh = shapes::wavy_sphere(4, 4.0);
        let mut last = usize::MAX;
        for error in [0.015, 0.05, 0.2] {
            let Bounded { simplified, distance, .. } = found(&mesh, error);
            let sampled = surface_distance(&Surface::new(&mesh, 20_000, 0), &Surface::new(&simplified.mesh, 20_000, 0));
            assert!(sampled.unwrap().both.max <= error && distance.upper <= error, "{distance:?}");
            assert!(distance.lower > 0.5 * error, "{distance:?}");
            assert!(simplified.mesh.positions().len() < last && topology(&simplified.mesh).is_closed_manifold());
            last = simplified.mesh.positions().len();
        }
    }

    #[test]
    fn no_error_at_all_leaves_flat_parts_or_the_whole() {
        let sphere = shapes::icosphere(3);
        assert_eq!(found(&sphere, 0.0).simplified.mesh, sphere);
        let cube = found(&shapes::cuboid([1.0; 3], 8), 2e-3);
        assert!(cube.simplified.mesh.positions().len() < 60, "{}", cube.simplified.mesh.positions().len());
    }
}
