//! Results of the simplifier before they are measured.

use crate::io::PackOptions;
use crate::metrics::CertifiedDistance;
use crate::simplify::Simplified;

use super::report::NamedShare;
use super::request::Job;

pub(super) struct SimplifiedResults {
    pub results: Vec<Simplified>,
    // Proved distance of each result, if the goal is a distance.
    pub certified: Vec<CertifiedDistance>,
    pub note: Option<&'static str>,
    pub pack: Option<PackOptions>,
    pub named: Vec<NamedShare>,
}

impl SimplifiedResults {
    pub fn new(results: Vec<Simplified>, job: &Job) -> Self {
        Self { results, certified: Vec::new(), note: None, pack: job.compress, named: Vec::new() }
    }
}
