//! The smallest result within a proved distance.

use std::cell::Cell;

use crate::mesh::TriMesh;
use crate::mesh::pulse::Pulse;
use crate::metrics::{CertifiedDistance, DistanceTolerance, MeasuredOriginal};
use crate::simplify::{
    ClosedOptions, Input, Listener, NextSize, Options, Outcome, Simplified, SimplifyError, Size, Turn, prune, simplify,
    simplify_in_turn,
};

use super::placed_original::PlacedOriginal;
use super::progress::Search;

/// Ratio of the mesh's size to the first that is looked at, where nothing estimates distances.
const FIRST_STEP: f64 = 7.0;
/// Size at which estimates end, the least of the kernel.
const LEAST_ESTIMATED: usize = 64;
/// Distance over its estimate, before a result is measured.
// Fourteen training meshes at ratios of 0.01 to 0.3: 0.6 to 1.4, median 0.83.
const USUAL_SHARE: f64 = 0.85;
/// Least ratio of a size to those known before; it is squared with each result on one side of the error.
const NEAR: f64 = 1.024;
/// The largest such ratio.
const FAR: f64 = 1.5;
/// Range of p, if distances are predicted to fall like 1 / n_vertices^p.
const POWERS: [f64; 2] = [0.5, 3.0];
const USUAL_POWER: f64 = 1.0;
/// Largest number of sizes looked at.
const MOST_TRIES: usize = 12;
/// Ratio of the smallest accepted to the largest rejected size at which the search ends.
// Distances fluctuate by more than 5 % between neighbouring sizes.
const CLOSE: f64 = 1.08;
/// Ratio of the smallest accepted size to the one from which on sizes are looked at once more.
const REOPENED: f64 = 1.4;
/// Least number of samples of each surface that decide, with all vertices, whether a result is worth a proof.
const SAMPLES: usize = 1000;
/// Least number of such samples per face of the result.
const SAMPLES_PER_FACE: usize = 4;
/// Share of the error below which distances are not measured.
const LEAST_SHARE: f64 = 0.3;
/// Largest share that can be proved: proofs are within 1 % of the distance.
const PROVABLE: f64 = 0.99;
/// Share of the allowed distance from which on a result is good enough to end the search.
const GOOD: f64 = 0.95;
/// Share of the allowed distance below which the smallest accepted result reopens the search, once.
const SPARE: f64 = 0.85;
/// Least quotient of the distances of a larger and a smaller result that shows that their dropped components are too far.
const UNMOVED: f64 = 0.98;
/// Shares of the distance within which components are dropped, in turn, once dropped ones are too far.
const CLOSER_DROPS: [f64; 2] = [0.5, 0.0];
/// Budget of visited triangles and boxes for all proofs: the first per face of the original, plus the second.
// On five benchmark meshes, within 0.3 % of the diagonal, 10 to 14 proofs visit 158 to 434 per face together.
const MOST_VISITS: [u64; 2] = [1000, 4_000_000];

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
    let mut search = Search::new(progress, 1.0);
    let prover = Prover::new(&original, bound);
    let mut hunt = Hunt::new(&prover);
    while let Some(first) = hunt.next {
        let options = &ClosedOptions { prune_within: hunt.drops_within * options.prune_within, ..options.clone() };
        simplify_in_turn(input, options, first, &mut search.run(), &mut |turn| hunt.go_on(turn))?;
    }
    let mut simplify_whole = |in_place: bool| {
        let closed = ClosedOptions { subset: in_place || options.subset, ..options.clone() };
        let size = Size::Vertices(original.n_vertices);
        simplify(*input, &Options::with_closed(size, closed), &mut search.run())
    };
    let Hunt { found, n_tries, .. } = hunt;
    let (mut simplified, distance) = match found {
        Some((found, distance)) => (found, CertifiedDistance { upper: distance.upper.min(bound), ..distance }),
        None => nearest(&prover, options, &mut simplify_whole)?,
    };
    let distance = add_rounding(distance, rounding);
    simplified.report.outcome = outcome(&distance, error);
    Ok(Bounded { simplified, distance, n_tries, ended_early: prover.is_any_open.get() })
}

/// Returns a result of the mesh's own size, with vertices left in place if that is nearer.
fn nearest(
    prover: &Prover,
    options: &ClosedOptions,
    simplify_whole: &mut dyn FnMut(bool) -> Result<Simplified, SimplifyError>,
) -> Result<(Simplified, CertifiedDistance), SimplifyError> {
    let mut whole = |in_place: bool| {
        let result = simplify_whole(in_place)?;
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

/// A result of which no sample is too far.
struct NearResult {
    /// The size asked for.
    size: usize,
    /// Largest distance of a sample over the error.
    share: f64,
    simplified: Simplified,
    proved: Option<CertifiedDistance>,
}

/// The hunt for the smallest result within the error.
struct Hunt<'a> {
    prover: &'a Prover<'a>,
    range: Range,
    /// Results of which no sample is too far, largest first.
    near: Vec<NearResult>,
    /// Size to make next; `None` if the hunt is over.
    next: Option<NextSize>,
    found: Option<(Simplified, CertifiedDistance)>,
    n_tries: usize,
    /// True once samples have missed what is too far.
    proves_at_once: bool,
    /// Share of the distance within which components are dropped.
    drops_within: f64,
    /// Number of vertices and distance of the last result, if it was too far and dropped components.
    last_dropping: Option<(usize, f64)>,
}

impl<'a> Hunt<'a> {
    fn new(prover: &'a Prover<'a>) -> Self {
        let range = Range::new(prover.original.n_vertices, prover.error);
        let next = Some(NextSize { n_vertices: LEAST_ESTIMATED, is_estimate: true });
        let (near, found, n_tries, proves_at_once) = (Vec::new(), None, 0, false);
        Self { prover, range, near, next, found, n_tries, proves_at_once, drops_within: 1.0, last_dropping: None }
    }

    /// Takes what was made, and returns the size to make next; `None` ends the run, after which the next size begins another.
    fn go_on(&mut self, turn: Turn) -> Option<NextSize> {
        let is_run_over = match turn {
            Turn::Estimates(estimates) => {
                self.range.estimates = DistanceEstimates::new(estimates);
                false
            }
            Turn::Result(simplified) => self.look_at(*simplified),
        };
        self.next = self.choose_next().map(|n_vertices| NextSize { n_vertices, is_estimate: false });
        self.next.filter(|_| !is_run_over)
    }

    /// Takes a result; returns whether larger ones of its run would be too far as well.
    fn look_at(&mut self, simplified: Simplified) -> bool {
        let Some(NextSize { n_vertices: size, .. }) = self.next else { return false };
        self.n_tries += 1;
        let share = self.prover.share_of_samples(&simplified);
        let is_near = share <= PROVABLE;
        let proved = (is_near && self.proves_at_once).then(|| self.prover.prove(&simplified, share)).flatten();
        let is_missed = is_near && self.proves_at_once && proved.is_none();
        let (n_vertices, drops) = (simplified.mesh.positions().len(), simplified.report.components_pruned > 0);
        if !is_missed {
            self.range.shares.push((n_vertices, share.max(LEAST_SHARE)));
        }
        if is_near && !is_missed {
            self.range.enough = size;
            self.near.push(NearResult { size, share, simplified, proved });
            return false;
        }
        self.range.too_few = self.range.too_few.max(size);
        let last = std::mem::replace(&mut self.last_dropping, drops.then_some((n_vertices, share)));
        let is_stuck = drops && last.is_some_and(|(n, before)| n_vertices > n && share > UNMOVED * before);
        is_stuck && self.keep_more_components()
    }

    /// Drops components within a smaller distance from now on, and forgets rejected sizes; `false` at the least distance.
    // What a run has dropped does not come back in its larger results.
    fn keep_more_components(&mut self) -> bool {
        let Some(&within) = CLOSER_DROPS.iter().find(|within| **within < self.drops_within) else { return false };
        (self.drops_within, self.last_dropping) = (within, None);
        let Range { enough, error, n_vertices, .. } = self.range;
        let estimates = std::mem::take(&mut self.range.estimates);
        self.range = Range { enough, estimates, ..Range::new(n_vertices, error) };
        self.range.shares.extend(self.near.last().map(|last| (last.size, last.share.max(LEAST_SHARE))));
        true
    }

    fn choose_next(&mut self) -> Option<usize> {
        loop {
            let next = self.range.next_size().filter(|_| self.n_tries < MOST_TRIES);
            // A constraint keeps the result larger than the requested size, so smaller sizes are useless.
            let is_larger = |last: &NearResult| last.simplified.mesh.positions().len() > last.size;
            if next.is_some() && !self.near.last().is_some_and(is_larger) && self.prover.left.get() > 0 {
                return next;
            }
            // Proofs take longer than results, so only the smallest result has one, and if it fails the next.
            let NearResult { size, share, simplified, proved } = self.near.pop()?;
            if let Some(distance) = proved.or_else(|| self.prover.prove(&simplified, share)) {
                self.found = Some((simplified, distance));
                return None;
            }
            self.proves_at_once = true;
            self.range.reject(size, self.near.last().map(|last| last.size));
        }
    }
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

    /// Returns the largest distance of samples and vertices over the error, or 0 if it is below `LEAST_SHARE`.
    fn share_of_samples(&self, simplified: &Simplified) -> f64 {
        if self.error == 0.0 {
            return 0.0;
        }
        let view = self.original.view_of(simplified);
        let n_samples = SAMPLES.max(SAMPLES_PER_FACE * view.faces().len());
        self.measured.largest_beyond(&view, n_samples, LEAST_SHARE * self.error) / self.error
    }

    /// Returns bounds of a result's distance if that is proved to be within the error; one sample has this share of it.
    fn prove(&self, simplified: &Simplified, share: f64) -> Option<CertifiedDistance> {
        let asked = DistanceTolerance { too_much: self.error, ..self.tolerance() };
        let view = self.original.view_of(simplified);
        let (distance, n_visits) =
            self.measured.certified_distance(&view, (&asked, share * self.error), self.left.get());
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
        self.measured.certified_distance(simplified, (&self.tolerance(), 0.0), u64::MAX).0.unwrap_or(unknown)
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
    error: f64,
    estimates: DistanceEstimates,
    /// Sizes of results with their distance over the error.
    shares: Vec<(usize, f64)>,
    /// True if the last size was predicted; within the interval the next then is not.
    was_predicted: bool,
    /// Sizes asked for before.
    asked: Vec<usize>,
    /// Least ratio of the next size to those known.
    step: f64,
    was_reopened: bool,
}

impl Range {
    fn new(n_vertices: usize, error: f64) -> Self {
        let (estimates, shares, asked) = (DistanceEstimates::default(), Vec::new(), Vec::new());
        let (enough, too_few, was_predicted, was_reopened) = (n_vertices, 0, false, false);
        Self { too_few, enough, n_vertices, error, estimates, shares, asked, was_predicted, step: NEAR, was_reopened }
    }

    /// Rejects the smallest accepted size, after which `enough` is the next.
    fn reject(&mut self, size: usize, enough: Option<usize>) {
        self.shares.retain(|&(n, share)| n > size || share > 1.0);
        (self.too_few, self.enough) = (size, enough.unwrap_or(self.n_vertices));
    }

    fn is_narrow(&self) -> bool {
        let is_good = |&(size, share): &(usize, f64)| size == self.enough && share > GOOD && share <= 1.0;
        self.shares.iter().any(is_good)
            || self.enough as f64 <= (self.too_few as f64 * CLOSE).max(self.too_few as f64 + 1.0)
    }

    /// Reopens sizes below the rejected ones, once, if the smallest accepted result is well within the error.
    fn reopens(&mut self) -> bool {
        let spares = |&(size, share): &(usize, f64)| size == self.enough && share < SPARE;
        let reopens = !self.was_reopened && self.shares.iter().any(spares);
        if reopens {
            (self.was_reopened, self.was_predicted) = (true, false);
            self.too_few = (self.enough as f64 / REOPENED) as usize;
        }
        reopens
    }

    /// Returns a size within the interval: the predicted one, or in turn with it the middle; `None` if it is narrow.
    fn next_size(&mut self) -> Option<usize> {
        if self.is_narrow() && !self.reopens() {
            return None;
        }
        let (low, high) = (self.too_few as f64, self.enough as f64);
        let has_both = self.too_few > 0 && self.enough < self.n_vertices;
        let predicted = self.predict_size().filter(|_| !(has_both && self.was_predicted));
        self.was_predicted = predicted.is_some();
        let middle = || if self.too_few > 0 { (low * high).sqrt() } else { high / FIRST_STEP };
        // Where all results are on one side, the error lies farther away than was thought.
        let step = if has_both { NEAR } else { self.step };
        self.step = (step * step).min(FAR);
        let [least, most] = [low * step, high / step];
        let size = if least < most { predicted.unwrap_or_else(middle).clamp(least, most) } else { (low * high).sqrt() };
        let size = size.round() as usize;
        // An interval of two numbers has none within.
        let within = size.max(self.too_few + 1).min(self.enough.saturating_sub(1));
        let is_new = within > self.too_few && within < self.enough && !self.asked.contains(&within);
        self.asked.push(within);
        is_new.then_some(within)
    }

    /// Predicts at which size the distance is the error.
    fn predict_size(&self) -> Option<f64> {
        let nearest = |known: &&(usize, f64)| ((known.1.ln()).abs() * 1e6) as u64;
        let Some(&(size, share)) = self.shares.iter().filter(|(_, share)| *share > 0.0).min_by_key(nearest) else {
            return self.estimates.size_at(self.error / USUAL_SHARE);
        };
        if let Some(estimate) = self.estimates.distance_at(size as f64) {
            // What is known of one size holds for others.
            return self.estimates.size_at(estimate / share);
        }
        // Through the nearest size on the other side, else the next on this.
        let others = self.shares.iter().filter(|&&(other, share)| share > 0.0 && other != size);
        let other = others.min_by_key(|(other, _)| (*other > size, other.abs_diff(size)));
        let power = other.map_or(USUAL_POWER, |&(other, other_share)| {
            (share / other_share).ln() / (other as f64 / size as f64).ln()
        });
        Some(size as f64 * share.powf(1.0 / power.clamp(POWERS[0], POWERS[1])))
    }
}

/// Estimates of the distance at falling sizes, as lines between logarithms.
#[derive(Default)]
struct DistanceEstimates(Vec<[f64; 2]>);

impl DistanceEstimates {
    fn new(estimates: &[(usize, f64)]) -> Self {
        let known = estimates.iter().filter(|(n, distance)| *n > 0 && *distance > 0.0 && distance.is_finite());
        let mut points: Vec<[f64; 2]> = known.map(|&(n, distance)| [(n as f64).ln(), distance.ln()]).collect();
        points.dedup_by(|next, last| next[1] <= last[1] || next[0] >= last[0]);
        Self(points)
    }

    fn distance_at(&self, size: f64) -> Option<f64> {
        self.interpolate(0, size.ln()).map(f64::exp)
    }

    fn size_at(&self, distance: f64) -> Option<f64> {
        self.interpolate(1, distance.ln()).map(f64::exp)
    }

    /// Returns the other coordinate where one has a value: on the segment around it, or the one nearest to it.
    fn interpolate(&self, axis: usize, value: f64) -> Option<f64> {
        let before = |point: &[f64; 2]| if axis == 0 { point[0] > value } else { point[1] < value };
        let next = self.0.iter().position(|point| !before(point)).unwrap_or(self.0.len());
        let first = next.clamp(1, self.0.len().saturating_sub(1).max(1)) - 1;
        let [from, to] = [self.0.get(first)?, self.0.get(first + 1)?];
        let along = (value - from[axis]) / (to[axis] - from[axis]);
        Some(from[1 - axis] + along * (to[1 - axis] - from[1 - axis]))
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
        assert!(
            enough.prove(&coarse, 0.0).is_some() && enough.left.get() < 10_000_000 && enough.left.get() > 9_000_000
        );
        assert!(few.prove(&coarse, 0.0).is_none() && few.left.get() == 0 && few.prove(&coarse, 0.0).is_none());
        assert!(!enough.is_any_open.get() && few.is_any_open.get());
    }

    #[test]
    fn what_was_dropped_too_far_is_kept_in_another_run() {
        let (sphere, away) = (shapes::icosphere(4), |p: [f32; 3]| [0.1 * p[0] + 1.5, 0.1 * p[1], 0.1 * p[2]]);
        let both = shapes::unite([&sphere, &shapes::place(&shapes::icosphere(1), away)]);
        let original = PlacedOriginal::from_input(&Input::bare(&both));
        let prover = Prover::new(&original, 0.3);
        let mut hunt = Hunt::new(&prover);
        let mut go_on = |n_vertices: usize| {
            let options = Options::new(Size::Vertices(n_vertices));
            let mut result = simplify(Input::bare(&sphere), &options, &mut |_| ControlFlow::Continue(())).unwrap();
            result.report.components_pruned = 1;
            hunt.next = Some(NextSize { n_vertices, is_estimate: false });
            let next = hunt.go_on(Turn::Result(Box::new(result)));
            (next, hunt.next, hunt.drops_within, hunt.range.too_few)
        };
        let (next, planned, within, too_few) = go_on(100);
        assert!(next.is_some() && planned.is_some() && within == 1.0 && too_few == 100);
        let (next, planned, within, too_few) = go_on(200);
        assert!(next.is_none() && planned.is_some() && within == CLOSER_DROPS[0] && too_few == 0);
        _ = go_on(300);
        assert_eq!(go_on(400).2, 0.0);
        // Then nothing else is to be kept.
        _ = go_on(500);
        assert!(go_on(600).0.is_some());
    }

    #[test]
    fn steps_reach_over_half_of_what_is_left_if_both_ends_are_far() {
        let range = |too_few| Range { too_few, step: FAR, ..Range::new(600, 1.0) };
        assert_eq!([300, 500].map(|too_few| range(too_few).next_size().unwrap()), [424, 548]);
    }

    #[test]
    fn estimates_are_lines_between_logarithms() {
        let estimates =
            DistanceEstimates::new(&[(2000, 0.05), (1000, 0.1), (900, 0.1), (500, 0.2), (100, 1.0), (50, 1.0)]);
        for (size, distance) in [(1000.0, 0.1), (250.0, 0.4), (4000.0, 0.025), (10.0, 10.0)] {
            let found = [estimates.distance_at(size), estimates.size_at(distance)].map(Option::unwrap);
            assert!((found[0] / distance - 1.0).abs() < 1e-9 && (found[1] / size - 1.0).abs() < 1e-9, "{found:?}");
        }
        for few in [&[][..], &[(100, 0.1)], &[(100, 0.0), (50, f64::NAN), (40, 0.1)]] {
            assert_eq!(DistanceEstimates::new(few).size_at(0.1), None);
        }
    }

    #[test]
    fn a_hunt_comes_to_the_smallest_size_that_is_near_in_few_steps() {
        // Distances fall like 1 / n, and estimates are wrong by a factor.
        for (factor, n_enough) in [(0.0, 700), (1.0, 700), (0.3, 700), (4.0, 700), (1.0, 60), (1.0, 9990)] {
            let mut range = Range::new(10_000, 1.0);
            let estimate = |n: usize| (n, factor * f64::from(n_enough) / n as f64);
            range.estimates = DistanceEstimates::new(&[5000, 1000, 200, 64].map(estimate));
            let mut n_steps = 0;
            while let Some(size) = range.next_size() {
                assert!(size > range.too_few && size < range.enough);
                let share = f64::from(n_enough) / size as f64;
                range.shares.push((size, share));
                if share > 1.0 {
                    range.too_few = size
                } else {
                    range.enough = size
                }
                n_steps += 1;
            }
            let found = range.enough as f64 / f64::from(n_enough);
            assert!((1.0..1.0 / GOOD + 0.01).contains(&found) && n_steps < 8, "{factor} {found} {n_steps}");
        }
    }

    #[test]
    fn an_interval_without_sizes_ends_the_hunt() {
        for (too_few, enough) in [(0, 1), (0, 2), (1, 2), (2, 3), (3, 4), (5, 7), (90, 92)] {
            for share in [0.0, 0.5, 0.97] {
                let mut range = Range { too_few, shares: vec![(enough, share)], ..Range::new(enough, 1.0) };
                for _ in 0..9 {
                    assert!(range.next_size().is_none_or(|size| size > range.too_few && size < enough));
                }
            }
        }
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
