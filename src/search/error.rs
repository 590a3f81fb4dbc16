//! The smallest result within a proved distance.

use std::cell::Cell;

use crate::mesh::TriMesh;
use crate::mesh::pulse::Pulse;
use crate::metrics::{CertifiedDistance, DistanceTolerance, MeasuredOriginal};
use crate::simplify::{
    ClosedOptions, Input, Listener, Outcome, Simplified, SimplifyError, Size, prune, simplify_levels_of_detail,
};

use super::placed_original::PlacedOriginal;
use super::progress::Search;

/// Number of sizes whose results one collapse yields.
// Refining the result of one size costs as much as the collapse.
const SIZES: usize = 3;
/// Ratio of the largest to the smallest size tried first.
const SPAN: f64 = 20.0;
/// Ratio of neighbouring sizes tried around a predicted one.
const NEAR: f64 = 1.1;
/// Range of p, if distances are predicted to fall like 1 / n_vertices^p.
const POWERS: [f64; 2] = [0.5, 3.0];
const USUAL_POWER: f64 = 1.0;
/// Largest number of collapses.
const MOST_ROUNDS: usize = 7;
/// Ratio of the smallest accepted to the largest rejected size at which the search ends.
// Distances fluctuate by more than 5 % between neighbouring sizes. Three sizes in an interval of `NEAR` differ by a
// factor of 1.024.
const CLOSE: f64 = 1.05;
/// Samples of each surface that decide, with all vertices, whether a result is worth a proof.
const SAMPLES: usize = 2_500;
/// Share of the allowed distance below which the smallest accepted result reopens the search, once.
const SPARE: f64 = 0.9;
/// Budget of visited triangles and boxes for all proofs: the first per face of the original, plus the second.
// On five benchmark meshes, within 0.3 % of the diagonal, 10 to 14 proofs visit 158 to 434 per face together.
const MOST_VISITS: [u64; 2] = [1000, 4_000_000];
/// Share of a round's progress that the collapse takes; its proofs take the rest.
const SHARE_OF_RUN: f32 = 0.4;

/// A result and its proved distance.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Bounded {
    /// Result; its outcome says whether the distance is proved.
    pub simplified: Simplified,
    /// Bounds of the two-sided largest distance between result and original.
    pub distance: CertifiedDistance,
    /// Number of meshes made during the search.
    pub n_tries: usize,
    /// True if proofs ran out of budget; a smaller result may exist.
    pub ended_early: bool,
}

/// Finds the smallest result whose two-sided largest distance from the mesh is proved to be at most `error`.
///
/// `error` is in the unit of the mesh. Only components within `error` of the rest are dropped to save vertices. Components
/// below `prune_below` and hidden ones to be dropped are removed first, and the distance is measured from the rest. A
/// smaller mesh may exist, since distances do not fall strictly with size. If no result is proved, returns the nearest
/// with [`Outcome::Stopped`].
///
/// # Errors
/// As [`simplify`](crate::simplify::simplify); [`SimplifyError::BadError`] if `error` is negative or not a
/// number.
///
/// ```
/// use std::ops::ControlFlow;
/// use neural_mesh::{mesh::shapes, search::simplify_to_error, simplify::{ClosedOptions, Input}};
/// let mesh = shapes::icosphere(4);
/// let options = ClosedOptions::default();
/// let go_on = &mut |_| ControlFlow::Continue(());
/// let found = simplify_to_error(&Input::bare(&mesh), &options, 0.02, go_on).unwrap();
/// assert!(found.distance.upper <= 0.02 && found.simplified.mesh.faces().len() < 1000);
/// ```
pub fn simplify_to_error(
    input: &Input,
    options: &ClosedOptions,
    error: f64,
    progress: &mut Listener,
) -> Result<Bounded, SimplifyError> {
    if error.is_nan() || error < 0.0 {
        return Err(SimplifyError::BadError(error));
    }
    input.check()?;
    let pruned = prune(Pulse::NONE, input, options)?;
    let pruned = pruned.input();
    let original = PlacedOriginal::from_input(&pruned);
    // Placing both meshes in the scene rounds positions to single precision.
    let rounding = 2.0 * original.rounding();
    let bound = (error - rounding).max(0.0);
    let options = &ClosedOptions { prune_within: options.prune_within.min(bound), ..options.clone() };
    let mut search = Search::new(progress, SHARE_OF_RUN);
    let mut levels = |sizes: &[usize], in_place: bool| {
        let options = ClosedOptions { subset: in_place || options.subset, ..options.clone() };
        let made = simplify_to_counts(input, &options, sizes, &mut search.run())?;
        search.look("proof")?;
        Ok(made)
    };
    let prover = Prover::new(&original, bound);
    let (best, n_tries) = smallest_within_error(&prover, &mut |sizes| levels(sizes, false))?;
    let (mut simplified, distance) = match best {
        Some((best, distance)) => (best, CertifiedDistance { upper: distance.upper.min(bound), ..distance }),
        None => nearest(&prover, options, &mut levels)?,
    };
    let distance = add_rounding(distance, rounding);
    simplified.report.outcome = outcome(&distance, error);
    Ok(Bounded { simplified, distance, n_tries, ended_early: prover.is_any_open.get() })
}

/// Returns a result of the mesh's own size, with vertices left in place if that is nearer.
fn nearest(
    prover: &Prover,
    options: &ClosedOptions,
    levels: &mut dyn FnMut(&[usize], bool) -> LevelResults,
) -> Result<(Simplified, CertifiedDistance), SimplifyError> {
    let mut whole = |in_place: bool| {
        let size = prover.original.n_vertices;
        let result = levels(&[size], in_place)?.pop().ok_or(SimplifyError::Empty)?;
        let distance = prover.bound_distance(&result);
        Ok::<_, SimplifyError>((result, distance))
    };
    let moved = whole(false)?;
    if moved.1.upper <= prover.error || options.subset {
        return Ok(moved);
    }
    let in_place = whole(true)?;
    Ok(if in_place.1.upper < moved.1.upper { in_place } else { moved })
}

/// Returns the triangles of a mesh by the bits of their points, sorted.
fn triangles(mesh: &TriMesh) -> Vec<[[u32; 3]; 3]> {
    let point = |vertex: u32| mesh.positions()[vertex as usize].map(f32::to_bits);
    let mut triangles: Vec<_> = mesh.faces().iter().map(|face| face.map(point)).collect();
    triangles.iter_mut().for_each(|triangle| triangle.sort_unstable());
    triangles.sort_unstable();
    triangles
}

fn outcome(found: &CertifiedDistance, error: f64) -> Outcome {
    if found.upper <= error {
        return Outcome::Reached;
    }
    let [asked, upper, lower] =
        [error, found.upper, found.lower].map(|distance| format_distance(distance, found.diagonal));
    Outcome::Stopped(format!(
        "no result is proved to be within {asked} of the original: the distance of this result is between {lower} and {upper}"
    ))
}

/// Formats a distance to three digits, such as `0.0731 (1 % of the diagonal)`.
fn format_distance(distance: f64, diagonal: f64) -> String {
    let digits = |value: f64| {
        let decimals = if value > 0.0 { (2.0 - value.log10().floor()).clamp(0.0, 17.0) as usize } else { 0 };
        format!("{value:.decimals$}")
    };
    format!("{} ({} % of the diagonal)", digits(distance), digits(100.0 * distance / diagonal.max(f64::MIN_POSITIVE)))
}

type MakeLevels<'a> = dyn FnMut(&[usize]) -> LevelResults + 'a;

type LevelResults = Result<Vec<Simplified>, SimplifyError>;

fn simplify_to_counts(
    input: &Input,
    options: &ClosedOptions,
    sizes: &[usize],
    progress: &mut Listener,
) -> Result<Vec<Simplified>, SimplifyError> {
    let sizes: Vec<Size> = sizes.iter().map(|&size| Size::Vertices(size)).collect();
    simplify_levels_of_detail(input, options, &sizes, progress)
}

/// Finds the smallest result within the error with its distance, and the number of results made.
fn smallest_within_error(
    prover: &Prover,
    levels: &mut MakeLevels,
) -> Result<(Option<(Simplified, CertifiedDistance)>, usize), SimplifyError> {
    let mut range = Range::new(prover.original.n_vertices);
    // Results of which no sample is too far, with the size asked for, largest first.
    let mut near: Vec<(usize, Simplified)> = Vec::new();
    let (mut n_tries, mut n_rounds) = (0, 0);
    loop {
        let is_over = range.is_narrow() && !range.reopens();
        let sizes = if is_over || n_rounds == MOST_ROUNDS { Vec::new() } else { range.sizes() };
        // A constraint keeps the result larger than the requested size, so smaller sizes are useless.
        let is_smallest = near.last().is_some_and(|(size, result)| result.mesh.positions().len() > *size);
        if sizes.is_empty() || is_smallest || prover.left.get() == 0 {
            // Proofs take longer than results, so only the smallest result has one, and if it fails the next.
            let Some((size, result)) = near.pop() else { return Ok((None, n_tries)) };
            if let Some(distance) = prover.prove(&result) {
                return Ok((Some((result, distance)), n_tries));
            }
            range.reject(size, near.last().map(|(size, _)| *size));
            continue;
        }
        n_rounds += 1;
        let mut results = levels(&sizes)?;
        n_tries += results.len();
        let n_near = count_within_error(&results, |result| {
            let share = prover.share_of_samples(result);
            range.shares.push((result.mesh.positions().len(), share));
            share <= 1.0
        });
        range.too_few = sizes.get(n_near).copied().unwrap_or(range.too_few);
        results.truncate(n_near);
        near.extend(sizes.into_iter().zip(results));
        range.enough = near.last().map_or(range.enough, |(size, _)| *size);
    }
}

/// Counts the results within the error, largest first, assuming that larger results are nearer.
fn count_within_error(results: &[Simplified], mut is_within_error: impl FnMut(&Simplified) -> bool) -> usize {
    let (mut low, mut high) = (0, results.len());
    while low < high {
        let middle = low.midpoint(high);
        if is_within_error(&results[middle]) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    low
}

/// Widens both bounds of a distance by `rounding`; an upper bound of 0 stays.
fn add_rounding(distance: CertifiedDistance, rounding: f64) -> CertifiedDistance {
    match distance.upper {
        0.0 => distance,
        upper => CertifiedDistance { lower: (distance.lower - rounding).max(0.0), upper: upper + rounding, ..distance },
    }
}

struct Prover<'a> {
    original: &'a PlacedOriginal<'a>,
    measured: MeasuredOriginal<'a>,
    error: f64,
    left: Cell<u64>,
    is_any_open: Cell<bool>,
}

impl<'a> Prover<'a> {
    fn new(original: &'a PlacedOriginal<'a>, error: f64) -> Self {
        let most = MOST_VISITS[0] * original.view.faces().len() as u64 + MOST_VISITS[1];
        let measured = MeasuredOriginal::new(&original.view);
        Self { original, measured, error, left: Cell::new(most), is_any_open: Cell::new(false) }
    }

    /// Returns the largest distance of samples and vertices, over the error.
    fn share_of_samples(&self, simplified: &Simplified) -> f64 {
        let found = self.measured.quick_distance(&self.original.view_of(simplified), SAMPLES, 0);
        found.map_or(0.0, |found| if found.max > 0.0 { found.max / self.error } else { 0.0 })
    }

    /// Returns bounds of a result's distance if that is proved to be within the error.
    fn prove(&self, simplified: &Simplified) -> Option<CertifiedDistance> {
        let asked = DistanceTolerance { too_much: self.error, ..self.tolerance() };
        let view = self.original.view_of(simplified);
        let (distance, n_visits) = self.measured.certified_distance(&view, &asked, self.left.get());
        self.left.set(self.left.get().saturating_sub(n_visits));
        let is_open = |distance: &CertifiedDistance| distance.lower <= self.error && distance.upper > self.error;
        self.is_any_open.set(self.is_any_open.get() || distance.as_ref().is_some_and(is_open));
        distance.filter(|distance| distance.upper <= self.error)
    }

    /// Bounds the distance of a result, within the error or not.
    fn bound_distance(&self, simplified: &Simplified) -> CertifiedDistance {
        let (original, simplified) = (self.measured.mesh(), &*self.original.view_of(simplified));
        if original.faces().len() == simplified.faces().len() && triangles(original) == triangles(simplified) {
            return CertifiedDistance { lower: 0.0, upper: 0.0, diagonal: original.diagonal() };
        }
        let unknown = CertifiedDistance { lower: 0.0, upper: f64::INFINITY, diagonal: original.diagonal() };
        self.measured.certified_distance(simplified, &self.tolerance(), u64::MAX).0.unwrap_or(unknown)
    }

    // An upper bound of half of the error suffices: a sharper one takes long on flat surfaces.
    fn tolerance(&self) -> DistanceTolerance {
        DistanceTolerance { enough: 0.5 * self.error, ..DistanceTolerance::default() }
    }
}

/// The interval of vertex counts between the largest rejected and the smallest accepted.
struct Range {
    too_few: usize,
    enough: usize,
    n_vertices: usize,
    /// Sizes of results with their distance over the error.
    shares: Vec<(usize, f64)>,
    /// True if the last sizes were predicted; the next ones then are not.
    were_predicted: bool,
    was_reopened: bool,
}

impl Range {
    fn new(n_vertices: usize) -> Self {
        let (shares, were_predicted, was_reopened) = (Vec::new(), false, false);
        Self { too_few: 0, enough: n_vertices, n_vertices, shares, were_predicted, was_reopened }
    }

    /// Rejects the smallest accepted size, after which `enough` is the next.
    fn reject(&mut self, size: usize, enough: Option<usize>) {
        self.shares.retain(|&(n, share)| n > size || share > 1.0);
        (self.too_few, self.enough) = (size, enough.unwrap_or(self.n_vertices));
    }

    fn is_narrow(&self) -> bool {
        self.enough as f64 <= (self.too_few as f64 * CLOSE).max(self.too_few as f64 + 1.0)
    }

    /// Reopens sizes below the rejected ones, once, if the smallest accepted result is well within the error.
    fn reopens(&mut self) -> bool {
        let spares = |&(size, share): &(usize, f64)| size == self.enough && share < SPARE;
        let reopens = !self.was_reopened && self.shares.iter().any(spares);
        if reopens {
            (self.was_reopened, self.were_predicted) = (true, false);
            self.too_few = (self.enough as f64 / NEAR.powi(SIZES as i32 + 1)) as usize;
        }
        reopens
    }

    /// Returns sizes in the interval, falling by equal factors: around the prediction, or across the interval.
    fn sizes(&mut self) -> Vec<usize> {
        let high = self.enough as f64;
        let low = if self.too_few > 0 { self.too_few as f64 } else { (high / SPAN).max(1.0) };
        let predicted = self.predict_size().filter(|_| !self.were_predicted && high > low * NEAR * NEAR);
        self.were_predicted = predicted.is_some();
        let sizes = match predicted {
            Some(predicted) => {
                let middle = predicted.clamp(low * NEAR, high / NEAR);
                vec![middle * NEAR, middle, middle / NEAR]
            }
            None => {
                let n_steps = if self.too_few > 0 { SIZES + 1 } else { SIZES };
                (1..=SIZES).map(|k| high * (low / high).powf(k as f64 / n_steps as f64)).collect()
            }
        };
        let mut sizes: Vec<usize> = sizes.into_iter().map(|size| size.round() as usize).collect();
        sizes.retain(|&size| size > self.too_few && size < self.enough);
        sizes.dedup();
        sizes
    }

    fn predict_size(&self) -> Option<f64> {
        let near = self.shares.iter().filter(|(_, share)| *share > 0.0 && *share <= 1.0);
        let &(size, share) = near.min_by_key(|(size, _)| *size)?;
        // Through the nearest size on the other side, else the next on this.
        let others = self.shares.iter().filter(|&&(other, share)| share > 0.0 && other != size);
        let other = others.min_by_key(|(other, _)| (*other > size, other.abs_diff(size)));
        let power = other.map_or(USUAL_POWER, |&(other, other_share)| {
            (share / other_share).ln() / (other as f64 / size as f64).ln()
        });
        Some(size as f64 * share.powf(1.0 / power.clamp(POWERS[0], POWERS[1])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ops::ControlFlow;

    use crate::mesh::{UnitedMesh, shapes, topology};
    use crate::metrics::{Surface, surface_distance};
    use crate::simplify::{Options, simplify};

    fn simplify_within(mesh: &TriMesh, error: f64) -> Bounded {
        let options = ClosedOptions::default();
        simplify_to_error(&Input::bare(mesh), &options, error, &mut |_| ControlFlow::Continue(())).unwrap()
    }

    #[test]
    fn no_sample_is_farther_than_asked_and_fewer_vertices_would_be() {
        let mesh = shapes::wavy_sphere(4, 4.0);
        let mut last = usize::MAX;
        for error in [0.015, 0.05, 0.2] {
            let Bounded { simplified, distance, .. } = simplify_within(&mesh, error);
            let sampled = surface_distance(&Surface::new(&mesh, 20_000, 0), &Surface::new(&simplified.mesh, 20_000, 0));
            assert!(sampled.unwrap().both.max <= error && distance.upper <= error, "{distance:?}");
            assert!(distance.lower > 0.5 * error, "{distance:?}");
            assert!(simplified.mesh.positions().len() < last && topology(&simplified.mesh).is_closed_manifold());
            last = simplified.mesh.positions().len();
        }
    }

    #[test]
    fn a_scene_is_proved_where_a_viewer_sees_it() {
        use crate::mesh::{Attributes, ScenePiece};
        // The scene shows one sphere twice; the second one is ten times as large.
        let (mesh, attributes) = (shapes::icosphere(4), Attributes::default());
        let places = [(1.0, 0.0), (10.0, 30.0)].map(|(scale, x)| {
            glam::DMat4::from_translation(glam::DVec3::new(x, 0.0, 0.0))
                * glam::DMat4::from_scale(glam::DVec3::splat(scale))
        });
        let find = |places: &[glam::DMat4], scale: f32, error: f64| {
            let piece = ScenePiece { mesh: &mesh, attributes: &attributes, scale: scale.into(), places };
            let united = UnitedMesh::new(&[piece]).unwrap();
            let mut input = Input::bare(&united.mesh);
            (input.attributes, input.scene) = (&united.attributes, Some(&united));
            let go_on = &mut |_| ControlFlow::Continue(());
            simplify_to_error(&input, &ClosedOptions::default(), error, go_on).unwrap()
        };
        let (found, alone) = (find(&places, 10.0, 0.2), find(&places[..1], 1.0, 0.02));
        let [scene, alone] = [&found, &alone].map(|found| found.simplified.mesh.positions().len() as f64);
        assert!((0.9..1.1).contains(&(scene / alone)), "{scene} {alone}");
        assert!(found.distance.upper <= 0.2 && found.distance.diagonal > 40.0, "{:?}", found.distance);
    }

    #[test]
    fn proofs_share_what_they_may_look_at() {
        let fine = shapes::icosphere(4);
        let options = Options::new(Size::Vertices(shapes::icosphere(2).positions().len()));
        let input = Input::bare(&fine);
        let coarse = simplify(input, &options, &mut |_| ControlFlow::Continue(())).unwrap();
        let original = PlacedOriginal::from_input(&input);
        let prover = |left| Prover { left: Cell::new(left), ..Prover::new(&original, 0.2) };
        let (enough, few) = (prover(10_000_000), prover(1000));
        assert!(enough.prove(&coarse).is_some() && enough.left.get() < 10_000_000 && enough.left.get() > 9_000_000);
        assert!(few.prove(&coarse).is_none() && few.left.get() == 0 && few.prove(&coarse).is_none());
        assert!(!enough.is_any_open.get() && few.is_any_open.get());
    }

    #[test]
    fn an_unmet_distance_is_reported() {
        let distance = CertifiedDistance { lower: 1.5e-6, upper: 2e-6, diagonal: 2.0 };
        let Outcome::Stopped(why) = outcome(&distance, 1e-6) else { panic!("{distance:?}") };
        let asked = "no result is proved to be within 0.00000100 (0.0000500 % of the diagonal) of the original: ";
        let found = "the distance of this result is between 0.00000150 (0.0000750 % of the diagonal) and 0.00000200 (";
        assert!(why.starts_with(&[asked, found].concat()), "{why}");
        assert_eq!(outcome(&distance, 2e-6), Outcome::Reached);
    }

    #[test]
    fn a_coarse_klein_bottle_stays_in_place_where_it_would_move_too_far() {
        let bottle = shapes::klein_bottle(6, 4);
        for error in [0.0, 1e-9, 1e-3] {
            let Bounded { simplified, distance, .. } = simplify_within(&bottle, error);
            assert_eq!(simplified.report.outcome, Outcome::Reached, "{error}");
            assert!(distance.upper <= error, "{error} {distance:?}");
        }
    }

    #[test]
    fn the_outcome_says_whether_touching_surfaces_meet_the_error() {
        let meshes = [
            shapes::touching_spheres(2),
            shapes::tetrahedra_sharing_edge(),
            shapes::tetrahedra_sharing_vertex(),
            shapes::klein_bottle(9, 5),
            shapes::moebius_strip(12, 3),
            shapes::thin_sheet(6, 1e-5),
        ];
        for mesh in &meshes {
            for percent in [0.0, 1e-6, 0.1, 2.0] {
                let error = 0.01 * percent * mesh.diagonal();
                let Bounded { simplified, distance, .. } = simplify_within(mesh, error);
                let surfaces = [mesh, &simplified.mesh].map(|mesh| Surface::new(mesh, 3000, 0));
                let sampled = surface_distance(&surfaces[0], &surfaces[1]).unwrap().both.max;
                let is_held = simplified.report.outcome == Outcome::Reached;
                assert_eq!(is_held, distance.upper <= error, "{percent} {distance:?}");
                assert!(sampled <= distance.upper + 1e-6 * mesh.diagonal(), "{percent} {sampled} {distance:?}");
            }
        }
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!(format_distance(0.073_123, 7.3123), "0.0731 (1.00 % of the diagonal)");
        assert_eq!(format_distance(0.0, 0.0), "0 (0 % of the diagonal)");
        assert_eq!(format_distance(1234.5, 1e7), "1234 (0.0123 % of the diagonal)");
    }

    #[test]
    fn no_error_at_all_leaves_flat_parts_or_the_whole() {
        let sphere = shapes::icosphere(3);
        assert_eq!(simplify_within(&sphere, 0.0).simplified.mesh, sphere);
        let cube = simplify_within(&shapes::cuboid([1.0; 3], 8), 2e-3);
        assert!(cube.simplified.mesh.positions().len() < 60, "{}", cube.simplified.mesh.positions().len());
    }
}
