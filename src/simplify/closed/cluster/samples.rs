//! How many samples are drawn, and their regions.

use crate::simplify::closed::original::Original;
use crate::simplify::closed::prepare::surface::Surface;
use crate::simplify::closed::prepare::uneven::is_uneven;
use crate::simplify::closed::request::Request;
use crate::simplify::limits::Limit;

use super::assignment::Assignment;
use super::cuts::cut_costly;
use super::darts::throw_darts;
use super::edge_lengths::EdgeLengths;
use super::sums::{Sum, sums};

/// Share of the samples that are darts; the rest is for cutting regions that cost too much. Twelve large training
/// meshes at ratios 0.03 to 0.15: the mean distance is 0.2 % farther at 0.8 and 1.2 % at 1, the largest 1 % and 6 %.
const DARTS: f64 = 0.9;
/// Above this share of the vertices the samples are all vertices: darts would take their time and leave out a tenth at
/// most.
const NEARLY_ALL: f64 = 0.9;
/// So many times as many samples where part of the surface is hidden and keeps few of its own.
const HIDDEN: f64 = 2.0;

/// How many samples a request asks for.
#[derive(Clone, Copy)]
pub struct SampleCount {
    /// Samples per vertex asked for.
    pub oversample: f64,
    /// Number of samples.
    n: usize,
    /// Number of darts.
    n_darts: usize,
}

impl SampleCount {
    /// As many samples as there are vertices where the surface asks for that, or where nearly all are wanted.
    pub fn of(surface: &Surface, request: &Request, limit: Limit) -> Self {
        let oversample = oversample(surface, request, limit);
        let least = least_samples(surface, limit);
        let wanted = (limit.size() as f64 * oversample).max(least as f64);
        let nearly_all = wanted >= NEARLY_ALL * surface.n_vertices() as f64;
        // Regions could meet across the plane of a half; what is flat here may bend in a pose.
        let takes_all = nearly_all || request.keep.half.is_some() || request.keep.purpose.counts_flat();
        let n = if takes_all { surface.n_vertices() } else { wanted as usize };
        Self { oversample, n, n_darts: ((n as f64 * DARTS) as usize).max(least) }
    }
}

/// Samples per vertex asked for; as many as there are vertices where the surface asks for that.
fn oversample(surface: &Surface, request: &Request, limit: Limit) -> f64 {
    let all = surface.n_vertices() as f64 / limit.size() as f64;
    let oversample = if request.hidden.is_empty() { request.oversample } else { HIDDEN * request.oversample };
    if request.all_if_uneven && all > oversample && is_uneven(surface) { all } else { oversample }
}

/// The samples below which the one pass could end under the limit: a vertex less is two faces less at most.
fn least_samples(surface: &Surface, Limit { vertices, faces, .. }: Limit) -> usize {
    let excess_faces = surface.faces.len().saturating_sub(faces);
    vertices.min(surface.n_vertices().saturating_sub(excess_faces / 2)).max(4)
}

/// Throws the darts, or takes every vertex where all are wanted.
pub fn draw(surface: &Surface, count: SampleCount, seed: u64) -> Assignment {
    if count.n >= surface.n_vertices() {
        return Assignment::identity(surface.n_vertices());
    }
    let lengths = EdgeLengths::new(surface);
    surface.pulse.beat(0);
    let assignment = throw_darts(surface, &lengths, count.n_darts, seed);
    surface.pulse.beat(0);
    assignment
}

/// Cuts regions that cost too much and gives locked vertices regions of their own. Returns the sums of the regions; none where
/// every vertex is one and none is locked.
pub fn cut(original: &Original, assignment: &mut Assignment, count: SampleCount) -> Vec<Sum> {
    let surface = &original.surface;
    let mut of_regions = Vec::new();
    if assignment.n_regions < surface.n_vertices() {
        of_regions = sums(surface, assignment);
        cut_costly(surface, assignment, &mut of_regions, count.n);
    }
    if assignment.set_apart(original.pins.locked_vertices()) { sums(surface, assignment) } else { of_regions }
}
