//! Results within given distances from the original.

use crate::io::PackOptions;
use crate::metrics::CertifiedDistance;
use crate::search::simplify_to_error;
use crate::simplify::{ClosedOptions, Event, Input, Outcome};

use super::document::Document;
use super::error::JobError;
use super::request::Job;
use super::simplified_results::SimplifiedResults;
use super::size::Bound;
use super::watch::Watch;

// Largest share of the allowed distance that rounding may take; above it, coordinates get more bits.
const ROUNDING_OF_ERROR: f64 = 0.125;
const ENDED_EARLY: &str = "the search ended early, so a smaller mesh may also meet the bound: needle-like faces and large intersecting faces take long to measure";

/// Finds the smallest result within each of the rising distances `bounds`.
pub(super) fn simplify_within(
    bounds: &[Bound],
    (document, input): (&Document, &Input),
    options: &ClosedOptions,
    job: &Job,
    watch: &mut dyn Watch,
) -> Result<SimplifiedResults, JobError> {
    let errors: Vec<f64> = bounds.iter().map(|bound| bound.to_absolute(document.diagonal())).collect();
    let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
    let mut found_results = SimplifiedResults::new(Vec::new(), job);
    found_results.pack = pack_below(least, document, job);
    let rounding = rounding_below(least, found_results.pack.as_ref(), document, job)?;
    for (number, error) in errors.iter().enumerate() {
        // Each distance takes an equal share of the progress bar.
        let mut forward_event = |mut event: Event| {
            event.total = (number as f32 + event.total) / errors.len() as f32;
            watch.event(event)
        };
        // The search leaves room for the rounding of the file.
        let found = simplify_to_error(input, options, error - rounding, &mut forward_event)?;
        found_results.note = found_results.note.or(found.ended_early.then_some(ENDED_EARLY));
        let (mut result, mut distance) = (found.simplified, add_rounding(&found.distance, rounding));
        // A result for a smaller distance is valid here too, and may be smaller if this search ended early.
        if let (Some(last), Some(distance_before)) = (found_results.results.last(), found_results.certified.last())
            && last.mesh.faces().len() <= result.mesh.faces().len()
            && last.report.outcome == Outcome::Reached
        {
            (result, distance) = (last.clone(), *distance_before);
        }
        found_results.results.push(result);
        found_results.certified.push(distance);
    }
    Ok(found_results)
}

/// Returns the distance by which writing moves vertices; fails if it reaches `error`.
fn rounding_below(error: f64, pack: Option<&PackOptions>, document: &Document, job: &Job) -> Result<f64, JobError> {
    let (rounding, format) = (document.rounding(job), job.format.name());
    let on_grid = pack.map_or(0.0, |pack| document.packed_rounding(pack.bits, error));
    if on_grid > 0.0 && on_grid >= error {
        let what = format!(
            "--compress moves vertices by up to {on_grid:.1e}, which is not less than the allowed distance: allow a larger distance, or leave --compress out"
        );
        return Err(JobError::Document(what));
    }
    if rounding > 0.0 && rounding >= error {
        let what = format!(
            "{format} rounds vertices by up to {rounding:.1e}, which is not less than the allowed distance: allow a larger distance, or write ply, obj or glb"
        );
        return Err(JobError::Document(what));
    }
    Ok(rounding + on_grid)
}

/// Chooses enough bits that rounding takes only a small share of `error`.
fn pack_below(error: f64, document: &Document, job: &Job) -> Option<PackOptions> {
    let asked = job.arguments.packing()?;
    let is_small = |bits: &u32| document.packed_rounding(*bits, error) <= ROUNDING_OF_ERROR * error;
    let most = PackOptions::MOST_BITS;
    Some(PackOptions { bits: (asked.bits..most).find(is_small).unwrap_or(most), ..asked })
}

fn add_rounding(distance: &CertifiedDistance, by: f64) -> CertifiedDistance {
    let mut wide = *distance;
    wide.lower = (wide.lower - by).max(0.0);
    wide.upper += by;
    wide
}
