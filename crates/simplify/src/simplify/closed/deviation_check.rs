//! Check that ends a collapse early where too few vertices are free to keep the shape.

use glam::Vec3;

use crate::geometry::triangle::area_normal;
use crate::simplify::limits::Limit;

use super::collapse::{Collapse, CollapseEnd};
use super::original::Original;
use super::output::Output;

/// The check runs when at least one output vertex in `CHECKED_ONE_IN` is held.
// With half of the vertices held, the mean distance doubles.
const CHECKED_ONE_IN: usize = 2;
/// Largest mean distance after a collapse, over that with nothing held; both before refinement.
// For charts of thirty faces the ratio is 3.9, and after refinement 2.7 to 3.8.
const MOST_GROWTH: f64 = 4.2;
/// Mean distance at unit size that is always acceptable.
const NEGLIGIBLE: f64 = 1e-4;
const STEP: f64 = 1.25;
const POINTS: usize = 4096;

pub struct DeviationCheck<'a>(Collapse<'a>);

impl<'a> DeviationCheck<'a> {
    /// Keeps a copy of the collapse, if one to `least` vertices may have to be repeated.
    pub fn new(collapse: &Collapse<'a>, least: usize) -> Option<Self> {
        (CHECKED_ONE_IN * collapse.n_held() >= least).then(|| Self(collapse.clone().without_progress()))
    }

    /// Repeats a collapse that ended too far from the original, to an earlier end; `None` otherwise.
    pub fn repeat_if_too_far(
        &self,
        ended: &Collapse,
        limit: Limit,
        distance: impl Fn(&Collapse) -> f64,
    ) -> Option<(Collapse<'a>, CollapseEnd)> {
        // With enough free vertices no distance needs to be measured.
        if CHECKED_ONE_IN * ended.n_held() < ended.n_vertices {
            return None;
        }
        // The surface may end up to `MOST_GROWTH` times as far from the original as in a collapse to the same size with
        // nothing held.
        let mut unconstrained = self.0.clone().without_constraints();
        unconstrained.run(limit);
        // Invisible distances are acceptable whatever their ratio.
        let most = (MOST_GROWTH * distance(&unconstrained)).max(NEGLIGIBLE);
        if distance(ended) <= most {
            return None;
        }
        let last = self.last_good_size(ended.n_vertices, |collapse| distance(collapse) <= most);
        // Each trial continues the one before, so the search costs one collapse and its distances.
        let mut collapse = self.0.clone();
        collapse.run(last);
        let end = CollapseEnd::TooFewFree(collapse.n_held(), collapse.n_vertices);
        Some((collapse, end))
    }

    /// Shrinks step by step and returns the last acceptable size above `least`.
    fn last_good_size(&self, least: usize, is_good: impl Fn(&Collapse) -> bool) -> Limit {
        let mut collapse = self.0.clone();
        let mut last = collapse.n_vertices;
        loop {
            // Only the number of free vertices shrinks from size to size.
            let n_held = collapse.n_held().min(last);
            let next = n_held + ((last - n_held) as f64 / STEP) as usize;
            collapse.run(Limit::from_vertices(next));
            let size = collapse.n_vertices;
            if size <= least || size >= last || !is_good(&collapse) {
                return Limit::from_vertices(last);
            }
            last = size;
        }
    }
}

/// Estimates the mean distance from the original to an output, at unit size.
pub fn distance(original: &Original, output: &Output) -> f64 {
    let tree = output.tree();
    let surface = &original.surface;
    let (mut sum, mut areas) = (0.0, 0.0);
    for face in surface.faces.iter().step_by(surface.faces.len().div_ceil(POINTS).max(1)) {
        let corners = face.map(|v| surface.positions[v as usize]);
        let area = f64::from(area_normal(corners).length());
        let centre = corners.iter().sum::<Vec3>() / 3.0;
        sum += area * tree.nearest(centre.as_dvec3()).map_or(0.0, |hit| hit.distance2.sqrt());
        areas += area;
    }
    if areas > 0.0 { sum / areas } else { 0.0 }
}
