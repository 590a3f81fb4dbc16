//! The smallest result found whose distance from the original is proved to be small enough.

use std::ops::ControlFlow;

use crate::mesh::TriMesh;
use crate::metrics::{CertifiedDistance, Sharpness, certified_distance, quick_distance};
use crate::model::Weights;
use crate::simplify::{Event, Input, Options, Simplified, SimplifyError, Target, simplify_input};

/// Share of the vertices to begin with.
const FIRST: f64 = 0.1;
/// Results tried at most.
const MOST_TRIES: usize = 12;
/// The search ends when a mesh smaller by this factor was too far from the original.
const CLOSE: f64 = 1.02;
/// Samples that tell about how far a result is from the original.
const SAMPLES: usize = 3000;
/// No guess is farther than this factor from the last one.
const STRIDE: f64 = 8.0;

/// A result and the proof.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounded {
    /// The result.
    pub simplified: Simplified,
    /// Bounds of its largest distance from the original, in either direction; the upper is at most what was asked.
    pub distance: CertifiedDistance,
    /// Results that were tried.
    pub n_tries: usize,
}

/// Finds the smallest result whose two-sided largest distance from the mesh is certainly at most `error`, in the unit
/// of the mesh; the target of `options` does not count.
///
/// Distances nearly fall with size, not quite: some smaller mesh may hold the error too.
///
/// # Errors
/// As [`simplify_input`]; [`SimplifyError::BadError`] where `error` is negative or not a number.
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
    progress: &mut dyn FnMut(Event) -> ControlFlow<()>,
) -> Result<Bounded, SimplifyError> {
    if error.is_nan() || error < 0.0 {
        return Err(SimplifyError::BadError(error));
    }
    let mut tried = |vertices: usize| {
        let options = Options { target: Target::Vertices(vertices), ..options.clone() };
        simplify_input(input, weights, &options, progress)
    };
    let n_all = input.mesh.positions().len();
    let mut range = Range { too_few: 0, enough: n_all };
    let mut best = None;
    let mut n_tries = 0;
    let mut guess = n_all as f64 * FIRST;
    while n_tries < MOST_TRIES && !range.is_narrow() {
        let vertices = range.nearest(guess);
        let result = tried(vertices)?;
        n_tries += 1;
        // Where something else holds the size, fewer vertices would change nothing.
        let n_left = result.mesh.positions().len().max(vertices);
        let about = quick_distance(input.mesh, &result.mesh, SAMPLES, 0).map_or(0.0, |distance| distance.max);
        if holds(input.mesh, &result.mesh, error) {
            range.enough = vertices;
            if result.mesh.positions().len() > vertices {
                range.too_few = vertices - 1;
            }
            best = Some(result);
        } else {
            range.too_few = n_left.min(range.enough - 1);
        }
        // The distance of a smooth surface falls as the number of vertices grows.
        guess = range.between(vertices as f64 * (about / error).clamp(1.0 / STRIDE, STRIDE));
    }
    let is_proved = best.is_some();
    let simplified = best.map_or_else(|| tried(n_all), Ok)?;
    // How far below the half it lies is of no interest, and takes long to say of flat parts.
    let asked = Sharpness { enough: 0.5 * error, ..Sharpness::default() };
    let sharp = certified_distance(input.mesh, &simplified.mesh, &asked).unwrap_or_default();
    let upper = if is_proved { sharp.upper.min(error) } else { sharp.upper };
    Ok(Bounded { simplified, distance: CertifiedDistance { upper, ..sharp }, n_tries })
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

    /// The number within that is nearest to a guess.
    fn nearest(&self, guess: f64) -> usize {
        (guess.round() as usize).clamp(self.too_few + 1, (self.enough - 1).max(self.too_few + 1))
    }

    /// A guess kept well within: no nearer to either end than a quarter of the way, by factors.
    fn between(&self, guess: f64) -> f64 {
        let (low, high) = ((self.too_few.max(1) as f64).ln(), (self.enough as f64).ln());
        let known = self.too_few > 0;
        let low = if known { low + 0.25 * (high - low) } else { low };
        guess.ln().clamp(low, low.max(high - if known { 0.25 * (high - low) } else { 0.0 })).exp()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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
