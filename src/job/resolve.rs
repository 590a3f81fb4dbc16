//! Options of a job that depend on its document.

use crate::simplify::{Assembly, Options, SEAM_ERROR, Target};

use super::document::Document;
use super::request::Job;
use super::shares;
use super::size::Bound;

pub fn options_for(document: &Document, job: &Job) -> Options {
    let mut options = job.options.clone();
    options.target = resolve_target(job.target(document.mesh().faces().len()), document, job);
    match &mut options.assembly {
        Assembly::Closed(closed) => {
            closed.frame = document.written_frame(job);
            closed.prune_below = job.arguments.prune_below().map_or(0.0, |size| size.to_absolute(document.diagonal()));
            let share =
                |most: Bound| most.to_absolute(document.diagonal()) / document.diagonal().max(f64::MIN_POSITIVE);
            closed.hold_shape = job.arguments.most_deformation().map(share);
            closed.seam_error =
                job.arguments.seam_error.map_or(SEAM_ERROR, |texels| document.share_of_texture(texels, job));
        }
        Assembly::Paper(_) => {}
    }
    options
}

// Named shares are simplified first and leave fewer vertices, so the ratio of all vertices becomes a number before.
pub fn resolve_target(target: Target, document: &Document, job: &Job) -> Target {
    if job.arguments.shares().is_empty() {
        target
    } else {
        shares::ratio_to_count(target, document.mesh().positions().len())
    }
}
