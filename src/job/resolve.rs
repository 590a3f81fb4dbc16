//! Options of a job that depend on its document.

use crate::simplify::{Assembly, Options, SEAM_ERROR, Size};

use super::document::Document;
use super::request::Job;
use super::size::Bound;

pub fn options_for(document: &Document, job: &Job) -> Options {
    let mut options = job.simplifier_options();
    options.target = resolve_target(options.target, document, job);
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

// Named shares are simplified first and leave less, so a share of the whole becomes a number before.
pub fn resolve_target(target: Size, document: &Document, job: &Job) -> Size {
    if job.arguments.shares().is_empty() {
        target
    } else {
        target.to_number(document.mesh().positions().len(), document.mesh().faces().len())
    }
}
